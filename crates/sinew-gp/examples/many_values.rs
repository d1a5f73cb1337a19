//! Twenty thousand values, in one dimension and in two.
//!
//! `cargo run -p sinew-gp --example many_values`
//!
//! Parameters are fitted to a few hundred of the values; the posterior is that of all of them, through those few that tell the
//! others, with a bound of its distance from the exact one. (Nearest neighbours, as in Vecchia's approximation, would do worse
//! here: errors of measurement average out over all values within a lengthscale, thousands of them.)

use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, GpError, Model, Noise, Parameter, Prior,
    Problem, ReducedOptions, Side, SquaredExponential, constant, field, laplace,
};
use std::f64::consts::PI;
use std::time::Instant;

const VALUES: usize = 20_000;
/// Standard deviation of measurements.
const ERROR: f64 = 0.05;

/// Errors without a generator of random numbers: uniform digits of a sine.
fn error(k: usize) -> f64 {
    let uniform = ((k as f64 + 1.0) * 12.9898).sin() * 43758.5453;
    ERROR * 12.0_f64.sqrt() * (uniform - uniform.floor() - 0.5)
}

fn solved<const D: usize>(
    problem: &Problem<D>,
    exact: fn([f64; D]) -> f64,
    name: &str,
    points: usize,
) -> Result<(), GpError> {
    let domain = problem.domain();
    let places = domain.sample(VALUES, 1)?;
    let y: Vec<f64> = places.iter().enumerate().map(|(k, x)| exact(*x) + error(k)).collect();
    let at = domain.sample(points, 2)?;
    let data = Data::new().values(&places, &y, Noise::Learned).equation(
        &at,
        &vec![0.0; points],
        Noise::Exact,
    );
    let prior = || Prior::constrained(problem, &SquaredExponential::new());
    let start = Instant::now();
    let fit =
        Model::new(prior()?, data.thinned(300, 1), Evidence::Auto)?.fit(&FitOptions::default())?;
    let [lower, upper] = laplace(&fit, 300, 1)?.interval(name, 0.95)?;
    let fitted = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let model = Model::new(prior()?, data, Evidence::Auto)?;
    let all = model.reduced(&fit, &ReducedOptions::default())?;
    let reduced = start.elapsed().as_secs_f64();
    let grid = domain.sample(300, 9)?;
    let start = Instant::now();
    let found = all.posterior.predict(&grid)?;
    let off = |mean: &[f64]| {
        mean.iter().zip(&grid).map(|(m, x)| (m - exact(*x)).abs()).sum::<f64>() / 300.0
    };
    let of_few = fit.posterior()?.mean(&grid)?;
    println!(
        "{D}-D: {name} in {lower:.4} to {upper:.4} from 300 values ({fitted:.1} s); {} of {} tell all ({reduced:.1} s), divergence below {:.0e}; mean error {:.1e} for {:.1e} with 300 values ({:.1} s for 300 places)",
        all.chosen,
        VALUES + points,
        all.divergence,
        off(&found.mean),
        off(&of_few),
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

fn main() -> Result<(), GpError> {
    // A string on a bed, u″ + w u = 0, in two waves.
    let string = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = string.derivatives();
    let bed = Parameter::new("w", [10.0, 2000.0])?;
    let problem = Problem::new(string, dx * dx + &bed * sinew_gp::Derivative::identity())?
        .condition("x", Side::Lower, Condition::Dirichlet(constant(0.0)))?;
    solved(&problem, |[x]| (4.0 * PI * x).sin(), "w", 40)?;

    // A slab that is washed at one face.
    let slab = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = slab.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let start = Condition::Dirichlet(field(|[x, _]| (x * (PI / 2.0)).cos()));
    let problem = Problem::new(slab, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, Condition::Neumann(constant(0.0)))?
        .condition("x", Side::Upper, Condition::Dirichlet(constant(0.0)))?
        .condition("t", Side::Lower, start)?;
    let exact = |[x, t]: [f64; 2]| (x * PI / 2.0).cos() * (-0.3 * PI * PI / 4.0 * t).exp();
    solved(&problem, exact, "D", 60)
}
