//! Derivatives of observables against differences.
#![allow(dead_code, reason = "each program uses a part")]

use sinew_calibrate::{Forward, Observed, Patient};

/// Derivatives against central differences of fourth order [relative to the largest of an observable].
const DIFFERENCE: f64 = 1e-6;

/// Step of the differences [relative to the parameter].
pub(crate) const STEP: f64 = 1e-3;
/// One that hardly takes a cell from fibres under tension to fibres under none, where the law has a kink.
pub(crate) const SHORT_STEP: f64 = 1e-5;

/// Holds the derivatives of all observables against differences.
pub(crate) fn check(name: &str, patient: &Patient<'_>, theta: &[f64]) -> Observed {
    check_rows(name, patient, theta, patient.observables(), STEP)
}

/// Holds those of the first observables; others may have none but rounding errors.
pub(crate) fn check_rows(
    name: &str,
    patient: &Patient<'_>,
    theta: &[f64],
    rows: usize,
    step: f64,
) -> Observed {
    let seen = patient.observe(theta, true).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(seen.values.len(), patient.observables());
    let mut worst: f64 = 0.0;
    for index in 0..theta.len() {
        let step = step * theta[index];
        let at = |steps: f64| {
            let mut theta = theta.to_vec();
            theta[index] += steps * step;
            patient.observe(&theta, false).unwrap_or_else(|e| panic!("{name}: {e}")).values
        };
        let [a, b, c, d] = [2.0, 1.0, -1.0, -2.0].map(at);
        for (row, slopes) in seen.jacobian.iter().enumerate().take(rows) {
            let difference = (8.0 * (b[row] - c[row]) - (a[row] - d[row])) / (12.0 * step);
            // In the scaled parameter, so that entries of different units compare.
            let scale = slopes.iter().zip(theta).map(|(s, t)| (s * t).abs()).fold(0.0, f64::max);
            let error = (slopes[index] - difference).abs() * theta[index];
            worst = worst.max(error / scale.max(f64::MIN_POSITIVE));
            assert!(
                error <= DIFFERENCE * scale,
                "{name}: observable {row} by parameter {index}: {} against {difference}",
                slopes[index]
            );
        }
    }
    println!("{name}: derivatives off by {worst:.1e}");
    seen
}
