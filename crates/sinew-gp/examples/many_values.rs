//! Twenty thousand values, or as many as the first argument says, in one dimension and in two.
//!
//! `cargo run -p sinew-gp --example many_values -- 20000`
//!
//! All values tell the parameters, as means over cells of neighbours (`Data::averaged`); bands are over what is not known of
//! these. Beside them the posterior of all values at the parameters of a few, with a bound of its distance from the exact one
//! (`Model::reduced`), which knows nothing of that.

use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, GpError, Model, Noise, Parameter, Prior,
    Problem, ReducedOptions, Side, SquaredExponential, constant, field,
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
    (name, truth): (&str, f64),
    [points, cells]: [usize; 2],
) -> Result<(), GpError> {
    let domain = problem.domain();
    let values = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(VALUES);
    let places = domain.sample(values, 1)?;
    let y: Vec<f64> = places.iter().enumerate().map(|(k, x)| exact(*x) + error(k)).collect();
    let at = domain.sample(points, 2)?;
    let data = Data::new().values(&places, &y, Noise::Learned).equation(
        &at,
        &vec![0.0; points],
        Noise::Exact,
    );
    let prior = || Prior::constrained(problem, &SquaredExponential::new());
    let start = Instant::now();
    let few =
        Model::new(prior()?, data.thinned(300, 1), Evidence::Auto)?.fit(&FitOptions::default())?;
    let [low, high] = few.interval(name, 0.95)?;
    let of_few = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let all = Model::new(prior()?, data.averaged(cells), Evidence::Auto)?;
    let all = all.fit(&FitOptions::default())?;
    let [lower, upper] = all.interval(name, 0.95)?;
    let seconds = start.elapsed().as_secs_f64();
    let grid = domain.sample(300, 9)?;
    let start = Instant::now();
    let found = all.predict(&grid)?;
    let off = |k: usize| (found.mean[k] - exact(grid[k])).abs();
    let error = (0..300).map(off).sum::<f64>() / 300.0;
    let held = (0..300).filter(|k| off(*k) <= 1.96 * found.standard_deviation[*k]).count();
    println!(
        "{D}-D: {name} in {lower:.5} to {upper:.5} for {truth:.5} from {values} values ({seconds:.1} s), in {low:.5} to {high:.5} from 300 ({of_few:.1} s); mean error {error:.1e}, bands hold {held} of 300 ({:.1} s)",
        start.elapsed().as_secs_f64()
    );
    print!("{all}");
    assert!(lower <= truth && truth <= upper && upper - lower < 0.3 * (high - low));
    assert!(held >= 264, "bands hold {held} of 300");
    let model = Model::new(prior()?, data, Evidence::Auto)?;
    match model.reduced(&few, &ReducedOptions::default()) {
        Ok(reduced) => println!(
            "  {} observations tell all others to {:.0e} nats, at the parameters of 300",
            reduced.chosen, reduced.divergence
        ),
        Err(refused) => println!("  {refused}"),
    }
    Ok(())
}

fn main() -> Result<(), GpError> {
    // A string on a bed, u″ + w u = 0, in two waves.
    let string = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = string.derivatives();
    let bed = Parameter::new("w", [10.0, 2000.0])?;
    let problem = Problem::new(string, dx * dx + &bed * sinew_gp::Derivative::identity())?
        .condition("x", Side::Lower, Condition::Dirichlet(constant(0.0)))?;
    solved(&problem, |[x]| (4.0 * PI * x).sin(), ("w", 16.0 * PI * PI), [40, 100])?;

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
    solved(&problem, exact, ("D", 0.3), [60, 150])
}
