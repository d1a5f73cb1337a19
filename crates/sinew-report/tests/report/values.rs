//! Values of tables and how they are written.

use crate::support::{report, table};
use sinew_report::{Distribution, ReportError, Row, Value, Verdict, format};

#[test]
fn a_row_needs_error_and_time() {
    for value in [f64::NAN, f64::INFINITY, -1.0] {
        assert!(
            matches!(Row::new("m", value, 1.0), Err(ReportError::Number(field, _)) if field.contains("first error"))
        );
        assert!(
            matches!(Row::new("m", 1.0, value), Err(ReportError::Number(field, _)) if field.contains("first time"))
        );
        let full = |error: f64, time: f64| {
            Row::new("m", 1.0, 1.0).unwrap().error(error).time(1.0).time(time).other(0.0)
        };
        assert!(table().push(full(1.0, 1.0)).is_ok());
        let message = table().push(full(value, 1.0)).unwrap_err().to_string();
        assert!(message.contains("m: err_F"), "{message}");
        let message = table().push(full(1.0, value)).unwrap_err().to_string();
        assert!(message.contains("m: decoder"), "{message}");
    }
    assert!(matches!(Row::new("m", "none", 1.0), Err(ReportError::Missing(_))));
    assert!(matches!(Row::new("m", 1.0, Value::Nothing), Err(ReportError::Missing(_))));
    assert!(matches!(table().push(Row::new("m", 1.0, 1.0).unwrap()), Err(ReportError::Length(..))));
    assert!(matches!(Distribution::with_density("e", vec![]), Err(ReportError::Missing(_))));
    assert!(matches!(
        Distribution::with_density("e", vec![1.0, f64::NAN]),
        Err(ReportError::Number(..))
    ));
}

#[test]
fn quantiles_agree_with_numpy() {
    // np.quantile([3, 1, 4, 1.5, 9.25, 2.6, 5.3], [0, .025, .25, .5, .75, .975, 1]) and the mean
    let found = Distribution::of(vec![3.0, 1.0, 4.0, 1.5, 9.25, 2.6, 5.3]).unwrap();
    let values = [
        found.q0,
        found.q2_5,
        found.q25,
        found.q50,
        found.q75,
        found.q97_5,
        found.q100,
        found.mean,
    ];
    let numpy = [1.0, 1.075, 2.05, 3.0, 4.65, 8.6575, 9.25, 3.807_142_857_142_857];
    for (value, expected) in values.into_iter().zip(numpy) {
        // Both interpolate in f64 and differ by rounding only.
        assert!((value - expected).abs() < 1e-14, "{value} for {expected}");
    }
    assert_eq!(Distribution::of(vec![f64::INFINITY; 2]).unwrap().q25, f64::INFINITY);
    assert_eq!((Distribution::of(vec![]), Distribution::of(vec![1.0, f64::NAN])), (None, None));
}

#[test]
fn densities_integrate_to_one_and_peak_where_samples_are() {
    // Evenly spaced quantiles of a logistic distribution of log₁₀ x.
    let logistic = |count: u32, centre: f64, scale: f64| -> Vec<f64> {
        let p = |i| (f64::from(i) + 0.5) / f64::from(count);
        (0..count).map(|i| 10f64.powf(centre + scale * (p(i) / (1.0 - p(i))).ln())).collect()
    };
    let cases =
        [vec![1e-3], vec![0.0, 2e-3, 2e-3], logistic(100, -2.0, 0.2), logistic(50_000, -3.0, 0.3)];
    for samples in cases {
        let density = sinew_report::density(&samples);
        let area =
            |pair: &[[f64; 2]]| (pair[1][0] / pair[0][0]).log10() * 0.5 * (pair[0][1] + pair[1][1]);
        let integral: f64 = density.windows(2).map(area).sum();
        // Cut tails of the kernel (6e-5) and the trapezoidal rule on bins.
        assert!((integral - 1.0).abs() < 2e-4, "{integral}");
    }
    let density = sinew_report::density(&logistic(20_000, -2.5, 0.25));
    let peak = density.into_iter().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap();
    // Half a bin, and the smoothing of the kernel (h²f″/2: 2.4 %).
    assert!(
        (peak[0].log10() + 2.5).abs() < 0.5 / 32.0 + 1e-9 && (peak[1] - 1.0).abs() < 0.03,
        "{peak:?}"
    );
    assert!(sinew_report::density(&[0.0, -1.0, f64::NAN, 1e9, f64::INFINITY]).is_empty());
}

#[test]
fn numbers_and_durations_read_well() {
    let beside = |value, error| format::digits_beside(value, error, 3);
    let values = [(1e6 + 0.9, 0.05), (76.7, 0.5), (0.9, 0.0), (0.0, 0.1), (-1e9, 1e-9)];
    let said = ["1.00000090×10⁶", "76.7", "0.900", "0", "−1.00000000000000×10⁹"];
    assert_eq!(values.map(|(value, error)| beside(value, error)), said);
    let digits = |value| format::digits(value, 2);
    let numbers = [
        6.5e-3,
        0.087,
        0.01,
        0.009_99,
        15.7,
        9.96,
        12_345.0,
        -1.2e-9,
        0.0,
        f64::NAN,
        -f64::INFINITY,
    ];
    let texts =
        ["6.5×10⁻³", "0.087", "0.010", "0.010", "16", "10", "1.2×10⁴", "−1.2×10⁻⁹", "0", "–", "−∞"];
    assert_eq!(numbers.map(digits), texts);
    let trimmed = [4.16, -26.612, 0.999_999_999_99, 1.2e-13, 0.0, 123_456.0, -0.00123, 100.0];
    let texts = ["4.16", "−26.612", "1", "1.2×10⁻¹³", "0", "123456", "−0.00123", "100"];
    assert_eq!(trimmed.map(|value| format::trimmed(value, 8)), texts);
    let durations = [2.1e-10, 2.1e-4, 0.0123, 2.14, 200.0, 3900.0, f64::NAN];
    let texts = ["0.21 ns", "210 µs", "12 ms", "2.1 s", "3 min 20 s", "1 h 05 min", "–"];
    assert_eq!(durations.map(format::seconds), texts);
    // What rounds to a whole of the next unit is written in that.
    let durations = [0.9996e-6, 0.9996e-3, 0.9996, 3599.6];
    assert_eq!(durations.map(format::seconds), ["1.0 µs", "1.0 ms", "1.0 s", "1 h 00 min"]);
    assert_eq!([1.09, 295.2, 4_123.0].map(format::factor), ["1.1×", "300×", "4\u{202f}100×"]);
    assert_eq!(format::count(1_234_567), "1\u{202f}234\u{202f}567");
}

#[test]
fn the_one_verdict_rule_counts_printed_digits() {
    let met = |ours, printed| Verdict::against_printed("thesis", ours, printed).met;
    assert!(met(4.94e-5, 4.9e-5) && met(4.9e-5, 4.9e-5) && met(0.0, 4.9e-5));
    assert!(
        !met(4.96e-5, 4.9e-5) && !met(1.0, 0.4) && !met(f64::NAN, 1.0) && !met(f64::INFINITY, 1.0)
    );
    assert_eq!(report().verdicts(), [2, 1]);
    let page = report().to_html();
    assert!(
        page.contains("1 of 2 not met") && page.contains("× the thesis’ 0.010"),
        "what is missed is said"
    );
    assert!(page.contains("<li>Once &amp; more, "), "and where");
}
