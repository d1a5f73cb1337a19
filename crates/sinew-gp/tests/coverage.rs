//! How often 95 % intervals hold the truth.

use std::f64::consts::PI;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_gp::{
    Condition, Data, Domain, Evidence, Fit, FitOptions, Model, Noise, NutsOptions, Parameter,
    Prior, Problem, Series, Side, SquaredExponential, constant, field, laplace, nuts,
};

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (2.0 * PI * random.random::<f64>()).cos()
}

/// A problem with its solution for θ = 1, and the solution's standard deviation.
struct Case {
    problem: Problem<2>,
    exact: fn([f64; 2]) -> f64,
    deviation: f64,
}

/// Heat-BVP-1.
fn heat() -> Case {
    let domain = must(Domain::cuboid([("x", [-PI / 2.0, PI / 2.0]), ("t", [0.0, 1.0])]));
    let [dx, dt] = domain.derivatives();
    let theta = must(Parameter::new("theta", [0.02, 50.0]));
    let end = |sign: f64| Condition::Dirichlet(field(move |[_, t]: [Series; 2]| (-t).exp() * sign));
    let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| x.sin()));
    let problem = must(
        Problem::new(domain, dt - &theta * dx * dx)
            .and_then(|p| p.condition("x", Side::Lower, end(-1.0)))
            .and_then(|p| p.condition("x", Side::Upper, end(1.0)))
            .and_then(|p| p.condition("t", Side::Lower, start)),
    );
    Case { problem, exact: |[x, t]| x.sin() * (-t).exp(), deviation: 0.47 }
}

/// Wave-BVP-1.
fn wave() -> Case {
    let domain = must(Domain::cuboid([("x", [0.0, PI]), ("t", [0.0, 1.0])]));
    let [dx, dt] = domain.derivatives();
    let speed = must(Parameter::new("theta", [0.05, 20.0]));
    let start = Condition::Cauchy {
        value: field(|[x, _]: [Series; 2]| x.cos()),
        slope: field(|[x, _]: [Series; 2]| x.cos().squared()),
    };
    let problem = must(
        Problem::new(domain, dt * dt - &speed * (&speed * dx * dx))
            .and_then(|p| p.condition("x", Side::Lower, Condition::Neumann(constant(0.0))))
            .and_then(|p| p.condition("x", Side::Upper, Condition::Neumann(constant(0.0))))
            .and_then(|p| p.condition("t", Side::Lower, start)),
    );
    let exact =
        |[x, t]: [f64; 2]| 0.5 * t + t.cos() * x.cos() + 0.25 * (2.0 * t).sin() * (2.0 * x).cos();
    Case { problem, exact, deviation: 0.65 }
}

/// 25 values with 2.5 % noise, and the equation at 25 points.
fn fitted(case: &Case, evidence: Evidence, seed: u64) -> Fit<2> {
    let domain = case.problem.domain();
    let mut random = ChaCha8Rng::seed_from_u64(9000 + seed);
    let places = must(domain.sample(25, seed));
    let noise = 0.025 * case.deviation;
    let y: Vec<f64> =
        places.iter().map(|x| (case.exact)(*x) + noise * normal(&mut random)).collect();
    let at = must(domain.sample(25, seed + 1000));
    let data =
        Data::new().values(&places, &y, Noise::Learned).equation(&at, &[0.0; 25], Noise::Exact);
    let prior = must(Prior::constrained(&case.problem, &SquaredExponential::new()));
    must(must(Model::new(prior, data, evidence)).fit(&FitOptions { seed, ..FitOptions::default() }))
}

#[test]
fn intervals_hold_the_truth() {
    // With 64 sets NUTS held it 59 times on Heat 1 and 59 of 63 on Wave 1; a few do for every day.
    let sets = std::env::var("SINEW_GP_SETS").ok().and_then(|s| s.parse().ok()).unwrap_or(4);
    for (name, case) in [("Heat 1", heat()), ("Wave 1", wave())] {
        let mut held = [0; 2];
        for seed in 0..sets {
            let fit = fitted(&case, Evidence::Auto, seed);
            assert_eq!(fit.model().ensemble_evidence(), Evidence::Conditional);
            let options = NutsOptions { seed, ..NutsOptions::default() };
            let ensembles = [must(nuts(&fit, &options)), must(laplace(&fit, 300, seed))];
            for (held, ensemble) in held.iter_mut().zip(&ensembles) {
                let [lower, upper] = must(ensemble.interval("theta", 0.95));
                *held += u64::from(lower <= 1.0 && 1.0 <= upper);
            }
            let [lower, upper] = must(ensembles[0].interval("theta", 0.95));
            let fitted = must(fit.parameter("theta"));
            println!("{name}, {seed}: {fitted:.4} in [{lower:.4}, {upper:.4}]");
        }
        println!("{name}: NUTS {} and Laplace {} of {sets}", held[0], held[1]);
        assert!(4 * held[0] >= 3 * sets, "{name}: {held:?} of {sets}");
    }
}
