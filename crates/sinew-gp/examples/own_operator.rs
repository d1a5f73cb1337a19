//! An equation of one's own: a beam on an elastic bed, of fourth order, with two unknown moduli.
//!
//! `cargo run --example own_operator -p sinew-gp`
//!
//! E u⁗ + k w(x) u = q for a strip that is clamped at both ends and bedded on gel, twice as stiff at
//! the right end as at the left. From twelve deflections under a known load q, which E and k?

use rand::{RngExt, SeedableRng};
use sinew_gp::{
    Condition, Data, Derivative, Domain, Evidence, FitOptions, Model, Noise, Parameter, Prior,
    Problem, Side, field, laplace, squared_exponential,
};
use std::error::Error;
use std::f64::consts::PI;
use std::time::Instant;

/// The truth: bending stiffness and bedding.
const MODULI: [f64; 2] = [1.5, 2000.0];
const ERROR: f64 = 0.005;

/// sin² πx is flat at both ends, as a clamped beam is.
fn deflection(x: f64) -> f64 {
    (PI * x).sin().powi(2)
}

/// The load that bends the beam so; (sin² πx)⁗ = −8 π⁴ cos 2πx.
fn load(x: f64) -> f64 {
    MODULI[0] * -8.0 * PI.powi(4) * (2.0 * PI * x).cos() + MODULI[1] * (1.0 + x) * deflection(x)
}

fn main() -> Result<(), Box<dyn Error>> {
    // Derivatives multiply to derivatives; numbers, parameters and functions stand to their left.
    let beam = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = beam.derivatives();
    let stiffness = Parameter::new("stiffness", [0.01, 100.0])?;
    let bedding = Parameter::new("bedding", [10.0, 1e5])?;
    let stiffening = field(|[x]| x + 1.0);
    let equation =
        &stiffness * dx * dx * dx * dx + &bedding * (stiffening * Derivative::identity());

    let problem = Problem::new(beam.clone(), equation)?
        .condition("x", Side::Lower, Condition::clamped())?
        .condition("x", Side::Upper, Condition::clamped())?;

    let mut random = rand::rngs::ChaCha8Rng::seed_from_u64(3);
    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    let places: Vec<[f64; 1]> = (1..=12).map(|k| [f64::from(k) / 13.0]).collect();
    let measured: Vec<f64> = places.iter().map(|[x]| deflection(*x) + ERROR * normal()).collect();
    let at = beam.grid(24);
    let loads: Vec<f64> = at.iter().map(|[x]| load(*x)).collect();
    let data = Data::new().values(&places, &measured, Noise::Known(ERROR)).equation(
        &at,
        &loads,
        Noise::Exact,
    );

    let start = Instant::now();
    let prior = Prior::constrained(&problem, &squared_exponential())?;
    let fit = Model::new(prior, data, Evidence::Auto)?.fit(&FitOptions::default())?;
    let ensemble = laplace(&fit, 500, 1)?;
    let seconds = start.elapsed().as_secs_f64();
    for (name, truth) in ["stiffness", "bedding"].into_iter().zip(MODULI) {
        let found = fit.parameter(name)?;
        let [lower, upper] = ensemble.interval(name, 0.95)?;
        let error = 100.0 * (found / truth - 1.0).abs();
        println!("{name} {found:.4}, error {error:.2} %, 95 % [{lower:.4}, {upper:.4}]");
        assert!(lower < truth && truth < upper, "the interval holds the truth");
    }
    let grid = beam.grid(101);
    let mean = fit.conditional()?.mean(&grid)?;
    let error =
        mean.iter().zip(&grid).map(|(u, [x])| (u - deflection(*x)).abs()).fold(0.0, f64::max);
    println!("largest error of the deflection {error:.1e}, all in {seconds:.2} s");
    assert!(error < ERROR, "the equation averages the instrument's errors out");
    Ok(())
}

#[test]
fn the_numbers_of_own_operator_hold() -> Result<(), Box<dyn Error>> {
    main()
}
