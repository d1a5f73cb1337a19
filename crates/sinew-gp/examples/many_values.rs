//! Twenty thousand values, or as many as the first argument says, in one dimension and in two; the second is the number of sets.
//!
//! `cargo run -p sinew-gp --example many_values -- 20000 5`
//!
//! All values tell the parameters, as means over cells of neighbours (`Data::averaged`); bands are over what is not known of
//! these. The width of the interval is held against the bound of Cramér and Rao, of least squares with the solution known for
//! every parameter.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, GpError, Model, Noise, Parameter, Prior,
    Problem, Side, constant, field, squared_exponential,
};
use std::f64::consts::PI;
use std::time::Instant;

const VALUES: usize = 20_000;
/// Standard deviation of measurements.
const ERROR: f64 = 0.05;

/// Normal variates, by the method of Box and Muller.
fn normal(random: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (2.0 * PI * random.random::<f64>()).cos()
}

/// The argument of this number, if there is one.
fn argument(number: usize) -> Option<usize> {
    std::env::args().nth(number).and_then(|word| word.parse().ok())
}

/// A problem with its solution, the parameter's name and true value, and the derivative of the solution in it.
struct Case<const D: usize> {
    problem: Problem<D>,
    exact: fn([f64; D]) -> f64,
    parameter: (&'static str, f64),
    slope: fn([f64; D]) -> f64,
    /// Collocation points, and cells that values are averaged over.
    counts: [usize; 2],
}

fn solved<const D: usize>(case: &Case<D>) -> Result<(), GpError> {
    let (values, sets) = (argument(1).unwrap_or(VALUES), argument(2).unwrap_or(1));
    let (mut held, mut shares) = (0, Vec::new());
    for set in 0..sets as u64 {
        let (inside, share) = one(case, values, set)?;
        held += usize::from(inside);
        shares.push(share);
    }
    let share = shares.iter().sum::<f64>() / sets as f64;
    println!("{D}-D: {held} of {sets} intervals hold, bands {:.0} % of the places", 100.0 * share);
    // Where one interval misses, so does most of the band: a share of few sets says little.
    assert!(10 * held >= 8 * sets && (sets < 20 || share >= 0.88));
    Ok(())
}

/// Whether the interval of one set of data holds, and the share of places at which the band does.
fn one<const D: usize>(case: &Case<D>, values: usize, set: u64) -> Result<(bool, f64), GpError> {
    let (domain, [points, cells], (name, truth)) =
        (case.problem.domain(), case.counts, case.parameter);
    let places = domain.sample(values, set + 1)?;
    let mut random = ChaCha8Rng::seed_from_u64(set);
    let y: Vec<f64> =
        places.iter().map(|x| (case.exact)(*x) + ERROR * normal(&mut random)).collect();
    let information: f64 = places.iter().map(|x| ((case.slope)(*x) / ERROR).powi(2)).sum();
    let data = Data::new().values(&places, &y, Noise::Learned).equation(
        &domain.sample(points, 2)?,
        &vec![0.0; points],
        Noise::Exact,
    );
    let start = Instant::now();
    let prior = Prior::constrained(&case.problem, &squared_exponential())?;
    let model = Model::new(prior, data.averaged(cells), Evidence::Auto)?;
    let fit = model.fit(&FitOptions::default())?;
    let [lower, upper] = fit.interval(name, 0.95)?;
    let grid = domain.sample(300, 9)?;
    let found = fit.predict(&grid)?;
    let seconds = start.elapsed().as_secs_f64();
    let off = |k: usize| (found.mean[k] - (case.exact)(grid[k])).abs();
    let error = (0..300).map(off).sum::<f64>() / 300.0;
    let held = (0..300).filter(|k| off(*k) <= 1.96 * found.standard_deviation[*k]).count();
    let width = (upper - lower) / (2.0 * 1.96) * information.sqrt();
    println!(
        "{D}-D: {name} in {lower:.5} to {upper:.5} for {truth:.5} from {values} values, {width:.2} of Cramér–Rao; mean error {error:.1e}, bands hold {held} of 300 ({seconds:.1} s)"
    );
    print!("{fit}");
    assert!(width < 1.5, "{width} of Cramér–Rao");
    Ok((lower <= truth && truth <= upper, held as f64 / 300.0))
}

fn main() -> Result<(), GpError> {
    // A string on a bed, u″ + w u = 0, in two waves.
    let string = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = string.derivatives();
    let bed = Parameter::new("w", [10.0, 2000.0])?;
    let problem = Problem::new(string, dx * dx + &bed * sinew_gp::Derivative::identity())?
        .condition("x", Side::Lower, Condition::Dirichlet(constant(0.0)))?;
    solved(&Case {
        problem,
        exact: |[x]| (4.0 * PI * x).sin(),
        parameter: ("w", 16.0 * PI * PI),
        slope: |[x]| x * (4.0 * PI * x).cos() / (8.0 * PI),
        counts: [40, 100],
    })?;

    // A slab that is washed at one face.
    let slab = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = slab.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let start = Condition::Dirichlet(field(|[x, _]| (x * (PI / 2.0)).cos()));
    let problem = Problem::new(slab, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, Condition::Neumann(constant(0.0)))?
        .condition("x", Side::Upper, Condition::Dirichlet(constant(0.0)))?
        .condition("t", Side::Lower, start)?;
    fn cooled([x, t]: [f64; 2]) -> f64 {
        (x * PI / 2.0).cos() * (-0.3 * PI * PI / 4.0 * t).exp()
    }
    solved(&Case {
        problem,
        exact: cooled,
        parameter: ("D", 0.3),
        slope: |[x, t]| -PI * PI / 4.0 * t * cooled([x, t]),
        counts: [60, 150],
    })
}
