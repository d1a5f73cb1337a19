//! How often intervals hold the truth: the slab of `diffusivity`, over many sets of noise.
//!
//! `cargo run --example coverage -p sinew-gp --no-default-features -- 40`
//!
//! For each evidence: the share of 95 % intervals of D that hold it, by Laplace's approximation and by
//! NUTS; and the share of 95 % bands of u, also with the parameters fixed at the fit (plug-in).

use std::error::Error;
use std::f64::consts::FRAC_PI_2;
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, GpError, Model, Noise, NutsOptions, Parameter,
    Prediction, Prior, Problem, Side, SquaredExponential, constant, field, laplace, nuts,
};

const DIFFUSIVITY: f64 = 0.3;
const ERROR: f64 = 0.02;

fn exact([x, t]: [f64; 2]) -> f64 {
    (FRAC_PI_2 * x).cos() * (-DIFFUSIVITY * FRAC_PI_2 * FRAC_PI_2 * t).exp()
}

fn slab() -> Result<Problem<2>, GpError> {
    let slab = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = slab.derivatives();
    let diffusivity = Parameter::new("diffusivity", [0.01, 10.0])?;
    let loaded = field(|[x, _]| (x * FRAC_PI_2).cos());
    Problem::new(slab, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, Condition::Neumann(constant(0.0)))?
        .condition("x", Side::Upper, Condition::Dirichlet(constant(0.0)))?
        .condition("t", Side::Lower, Condition::Dirichlet(loaded))
}

/// 25 noisy values and 25 collocation points.
fn data(domain: &Domain<2>, seed: u64) -> Result<Data<2>, GpError> {
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    let places = domain.sample(25, seed)?;
    let measured: Vec<f64> = places.iter().map(|x| exact(*x) + ERROR * normal()).collect();
    let at = domain.sample(25, seed + 10_000)?;
    Ok(Data::new().values(&places, &measured, Noise::Learned).equation(
        &at,
        &[0.0; 25],
        Noise::Exact,
    ))
}

fn main() -> Result<(), Box<dyn Error>> {
    let sets: u64 = std::env::args().nth(1).map_or(Ok(4), |word| word.parse())?;
    let problem = slab()?;
    let inside = problem.domain().sample(50, 99)?;
    let held = |band: &Prediction| {
        let off = |k: usize| (band.mean[k] - exact(inside[k])).abs() < 1.96 * band.deviation[k];
        (0..inside.len()).filter(|k| off(*k)).count() as f64 / inside.len() as f64
    };
    for evidence in [Evidence::Joint, Evidence::Conditional] {
        let start = Instant::now();
        // D by Laplace and NUTS; u by plug-in, Laplace and NUTS; mean error of D.
        let mut shares = [0.0; 6];
        for seed in 0..sets {
            let prior = Prior::constrained(&problem, &SquaredExponential::new())?;
            let model = Model::new(prior, data(problem.domain(), seed)?, evidence)?;
            let fit = model.fit(&FitOptions { seed, ..FitOptions::default() })?;
            let normal = laplace(&fit, 200, seed)?;
            let sampled = nuts(&fit, &NutsOptions { seed, ..NutsOptions::default() })?;
            let holds = |[lower, upper]: [f64; 2]| {
                f64::from(u8::from(lower < DIFFUSIVITY && DIFFUSIVITY < upper))
            };
            let found = [
                holds(normal.interval("diffusivity", 0.95)?),
                holds(sampled.interval("diffusivity", 0.95)?),
                held(&fit.posterior()?.predict(&inside)?),
                held(&normal.predict(&inside)?),
                held(&sampled.predict(&inside)?),
                (fit.parameter("diffusivity")? / DIFFUSIVITY - 1.0).abs(),
            ];
            shares.iter_mut().zip(found).for_each(|(share, f)| *share += 100.0 * f / sets as f64);
        }
        let [d_laplace, d_nuts, u_plug_in, u_laplace, u_nuts, error] = shares;
        println!(
            "{evidence:?}, {sets} sets: D {d_laplace:.0} % Laplace, {d_nuts:.0} % NUTS; \
             u {u_plug_in:.0} % plug-in, {u_laplace:.0} % Laplace, {u_nuts:.0} % NUTS; \
             mean error of D {error:.1} %; {:.1} s",
            start.elapsed().as_secs_f64()
        );
    }
    Ok(())
}
