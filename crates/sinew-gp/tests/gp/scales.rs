//! Neither the size of a load nor the unit of a length changes the answer, whatever the ends of a beam.

use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, GpError, Model, Noise, Prior, Problem, Side,
    constant, squared_exponential,
};
use std::f64::consts::PI;

/// Beam of length `length` with u⁗ as given at `count` points of a grid: its deflection at a share of its length with the
/// standard deviation, and the number of warnings.
fn beam(
    [left, right]: [Condition<1>; 2],
    (load, length): (&dyn Fn(f64) -> f64, f64),
    count: usize,
    at: f64,
) -> Result<([f64; 2], usize), GpError> {
    let domain = Domain::interval("x", [0.0, length])?;
    let [dx] = domain.derivatives();
    let problem = Problem::new(domain, dx * dx * dx * dx)?
        .condition("x", Side::Lower, left)?
        .condition("x", Side::Upper, right)?;
    let share = |k: usize| (k as f64 + 0.5) / count as f64;
    let places: Vec<[f64; 1]> = (0..count).map(|k| [length * share(k)]).collect();
    let loads: Vec<f64> = (0..count).map(|k| load(share(k))).collect();
    let data = Data::new().equation(&places, &loads, Noise::Exact);
    let prior = Prior::constrained(&problem, &squared_exponential())?;
    let fit = Model::new(prior, data, Evidence::Auto)?.fit(&FitOptions::default())?;
    let found = fit.conditional()?.predict(&[[at * length]])?;
    Ok(([found.mean[0], found.standard_deviation[0]], fit.warnings()?.len()))
}

type Ends = fn() -> [Condition<1>; 2];

/// Ends of a beam of length one, where it is looked at, and its deflection there under a load of one.
const CASES: [(&str, Ends, f64, f64); 6] = [
    ("clamped and free", || [Condition::clamped(), Condition::free_end()], 1.0, 1.0 / 8.0),
    ("free and clamped", || [Condition::free_end(), Condition::clamped()], 0.0, 1.0 / 8.0),
    (
        "half of a supported one",
        || [Condition::simply_supported(), Condition::symmetry()],
        1.0,
        5.0 / 24.0,
    ),
    ("half of a clamped one", || [Condition::clamped(), Condition::symmetry()], 1.0, 1.0 / 24.0),
    ("clamped at both", || [Condition::clamped(), Condition::clamped()], 0.5, 1.0 / 384.0),
    (
        "clamped and supported",
        || [Condition::clamped(), Condition::simply_supported()],
        0.5,
        1.0 / 192.0,
    ),
];

#[test]
fn eight_loads_bend_a_beam_whatever_their_size_and_its_length() -> Result<(), GpError> {
    for (name, ends, at, deflection) in CASES {
        for (load, length) in
            [(1.0, 1.0_f64), (24.0, 1.0), (1e-9, 1.0), (1e9, 1.0), (1.0, 1e-3), (1.0, 1e3)]
        {
            let unit = load * length.powi(4);
            let ([mean, sigma], warnings) = beam(ends(), (&|_| load, length), 8, at)?;
            let (mean, sigma) = (mean / unit, sigma / unit);
            println!(
                "{name}, load {load:e}, length {length:e}: {mean:.7} ± {sigma:.0e} for {deflection:.7}"
            );
            // The solution is a polynomial of the features; eight loads leave what lies between them.
            assert!((mean - deflection).abs() < 1e-4 * deflection, "{name}: {mean}");
            assert!((mean - deflection).abs() < 4.0 * sigma && sigma < 1e-3 * deflection);
            assert_eq!(warnings, 0, "{name}");
        }
    }
    Ok(())
}

#[test]
fn loads_that_vary_bend_a_cantilever() -> Result<(), GpError> {
    // u⁗ = (1 − s)³: u = (1 − s)⁷/840 + s/120 − 1/840, and u⁗ = π⁴ cos(πs): u = cos(πs) − 1 + π²s²/2.
    let tip = PI * PI / 2.0 - 2.0;
    type Load = fn(f64) -> f64;
    let cases: [(Load, f64, f64); 2] = [
        (|s| (1.0 - s).powi(3), 1.0 / 120.0 - 1.0 / 840.0, 1e-4),
        (|s| PI.powi(4) * (PI * s).cos(), tip, 1e-3),
    ];
    for (load, expected, share) in cases {
        // The second one is held by a moment at its end: u″ = 2π², u‴ = 0.
        let moment = if expected == tip { 2.0 * PI * PI } else { 0.0 };
        let end = Condition::Derivatives(vec![(2, constant(moment)), (3, constant(0.0))]);
        let ([mean, sigma], _) = beam([Condition::clamped(), end], (&load, 1.0), 12, 1.0)?;
        println!("tip {mean:.6} ± {sigma:.0e} for {expected:.6}");
        assert!((mean - expected).abs() < share * expected, "{mean} for {expected}");
        assert!((mean - expected).abs() < 4.0 * sigma, "{mean} ± {sigma} for {expected}");
    }
    Ok(())
}
