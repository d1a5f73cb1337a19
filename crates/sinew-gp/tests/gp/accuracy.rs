//! Problems of the thesis' chapter 4, against their exact solutions.

use sinew_gp::{
    Condition, Data, Derivative, Domain, Evidence, Fit, FitOptions, Model, Noise, Operator,
    Parameter, Periodicity, Prior, Problem, Series, Side, constant, field, squared_exponential,
};
use std::f64::consts::PI;

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// Mean |u − û| over a grid (4.50).
fn error<const D: usize>(fit: &Fit<D>, domain: &Domain<D>, exact: impl Fn([f64; D]) -> f64) -> f64 {
    let grid = domain.grid([200, 40, 14][D - 1]);
    let mean = must(must(fit.conditional()).mean(&grid));
    let sum: f64 = mean.iter().zip(&grid).map(|(m, x)| (m - exact(*x)).abs()).sum();
    sum / grid.len() as f64
}

/// Noisy values of u and homogeneous collocation, as in §4.8.
fn observed<const D: usize>(
    domain: &Domain<D>,
    exact: impl Fn([f64; D]) -> f64,
    [values, collocation]: [usize; 2],
    noise: f64,
    seed: u64,
) -> Data<D> {
    let points = must(domain.sample(values, seed));
    let size = domain.grid([100, 30, 12][D - 1]).into_iter().map(&exact).collect::<Vec<_>>();
    let mean = size.iter().sum::<f64>() / size.len() as f64;
    let deviation =
        (size.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / size.len() as f64).sqrt();
    // Sums of twelve uniform variates are near enough to normal ones.
    let errors =
        must(Domain::interval("e", [0.0, 1.0]).and_then(|e| e.sample(12 * values, seed + 77)));
    let y: Vec<f64> = points
        .iter()
        .zip(errors.chunks(12))
        .map(|(x, e)| {
            let normal = e.iter().map(|e| e[0]).sum::<f64>() - 6.0;
            exact(*x) + noise * deviation * normal
        })
        .collect();
    let at = must(domain.sample(collocation, seed + 1000));
    Data::new().values(&points, &y, Noise::Learned).equation(
        &at,
        &vec![0.0; collocation],
        Noise::Exact,
    )
}

fn fit<const D: usize>(prior: Prior<D>, data: Data<D>, seed: u64) -> Fit<D> {
    let model = must(Model::new(prior, data, Evidence::Auto));
    must(model.fit(&FitOptions { restarts: 4, seed, most_points: 0, ..FitOptions::default() }))
}

fn report<const D: usize>(label: &str, fit: &Fit<D>, err: f64, theta: &str) {
    let outcome = fit.outcome();
    let value = fit.parameter(theta).unwrap_or(f64::NAN);
    let all: Vec<String> = fit
        .restarts
        .iter()
        .map(|r| {
            r.outcome.as_ref().map_or("x".into(), |o| {
                format!("{:.3}{}", o.log_evidence, if o.collapsed { "c" } else { "" })
            })
        })
        .collect();
    println!(
        "{label}: err_u {err:.2e}, θ {value:.5}, evidence {:.3}, {} evaluations, jitter {:e}, collapsed {}, all {all:?}",
        outcome.log_evidence, outcome.evaluations, outcome.jitter, outcome.collapsed
    );
}

#[test]
fn poisson_1_needs_four_collocation_points() {
    // −u'' = f with f = −2 (the thesis prints 2), u = x², u(0) = u'(0) = 0, u'(2) = u(2).
    let domain = must(Domain::interval("x", [0.0, 2.0]));
    let [dx] = domain.derivatives();
    let robin = Condition::Robin {
        value_factor: constant(-1.0),
        slope_factor: constant(1.0),
        data: constant(0.0),
    };
    let problem = must(
        Problem::new(domain.clone(), -(dx * dx))
            .and_then(|p| p.condition("x", Side::Lower, Condition::clamped()))
            .and_then(|p| p.condition("x", Side::Upper, robin)),
    );
    for count in [4, 8] {
        let at: Vec<[f64; 1]> = (1..=count).map(|k| [2.0 * k as f64 / count as f64]).collect();
        let data = Data::new().equation(&at, &vec![-2.0; count], Noise::Exact);
        let prior = must(Prior::constrained(&problem, &squared_exponential()));
        let fit = fit(prior, data, 1);
        let err = error(&fit, &domain, |[x]| x * x);
        report(&format!("Poisson 1, {count}"), &fit, err, "-");
        // The thesis reaches 4.9e-5 with four points.
        assert!(err < 1e-7, "{err:e}");
    }
}

#[test]
fn heat_1_gives_the_diffusivity() {
    let domain = must(Domain::cuboid([("x", [-PI / 2.0, PI / 2.0]), ("t", [0.0, 1.0])]));
    let [dx, dt] = domain.derivatives();
    let theta = must(Parameter::new("theta", [0.02, 50.0]));
    let end = |sign: f64| Condition::Dirichlet(field(move |[_, t]: [Series; 2]| (-t).exp() * sign));
    let problem = must(
        Problem::new(domain.clone(), dt - &theta * dx * dx)
            .and_then(|p| p.condition("x", Side::Lower, end(-1.0)))
            .and_then(|p| p.condition("x", Side::Upper, end(1.0)))
            .and_then(|p| {
                let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| x.sin()));
                p.condition("t", Side::Lower, start)
            }),
    );
    let exact = |[x, t]: [f64; 2]| x.sin() * (-t).exp();
    for seed in 0..seeds() {
        let prior = must(Prior::constrained(&problem, &squared_exponential()));
        let fit = fit(prior, observed(&domain, exact, [25, 25], 0.025, seed), seed);
        let err = error(&fit, &domain, exact);
        report("Heat 1", &fit, err, "theta");
        assert!(!fit.outcome().collapsed);
        assert!(err < 2e-3, "{err:e}");
        assert!((must(fit.parameter("theta")) - 1.0).abs() < 0.02);
    }
}

#[test]
fn wave_1_gives_the_speed() {
    let domain = must(Domain::cuboid([("x", [0.0, PI]), ("t", [0.0, 1.0])]));
    let [dx, dt] = domain.derivatives();
    let speed = must(Parameter::new("theta", [0.05, 20.0]));
    let start = Condition::initial(
        field(|[x, _]: [Series; 2]| x.cos()),
        field(|[x, _]: [Series; 2]| x.cos().squared()),
    );
    let problem = must(
        Problem::new(domain.clone(), dt * dt - &speed * (&speed * dx * dx))
            .and_then(|p| p.condition("x", Side::Lower, Condition::Neumann(constant(0.0))))
            .and_then(|p| p.condition("x", Side::Upper, Condition::Neumann(constant(0.0))))
            .and_then(|p| p.condition("t", Side::Lower, start)),
    );
    let exact =
        |[x, t]: [f64; 2]| 0.5 * t + t.cos() * x.cos() + 0.25 * (2.0 * t).sin() * (2.0 * x).cos();
    for seed in 0..seeds() {
        let prior = must(Prior::constrained(&problem, &squared_exponential()));
        let fit = fit(prior, observed(&domain, exact, [25, 25], 0.025, seed), seed);
        let err = error(&fit, &domain, exact);
        report("Wave 1", &fit, err, "theta");
        assert!(!fit.outcome().collapsed);
        assert!(err < 3e-2, "{err:e}");
    }
}

#[test]
fn wave_2_is_periodic() {
    let domain = must(Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.5, 2.5])]));
    let [dx, dt] = domain.derivatives();
    let speed = must(Parameter::new("theta", [0.05, 20.0]));
    let start = Condition::initial(field(|[x, _]: [Series; 2]| (x * PI).sin()), constant(0.0));
    let problem = must(
        Problem::new(domain.clone(), dt * dt - &speed * (&speed * dx * dx))
            .and_then(|p| p.periodic("x", Periodicity::Value))
            .and_then(|p| p.condition("t", Side::Lower, start)),
    );
    let exact = |[x, t]: [f64; 2]| (PI * x).sin() * ((t - 0.5) * PI).cos();
    for seed in 0..seeds() {
        let prior = must(Prior::constrained(&problem, &squared_exponential()));
        let fit = fit(prior, observed(&domain, exact, [25, 25], 0.025, seed), seed);
        let err = error(&fit, &domain, exact);
        report("Wave 2", &fit, err, "theta");
        assert!(!fit.outcome().collapsed);
        assert!((must(fit.parameter("theta")) - 1.0).abs() < 0.02);
    }
}

#[test]
fn heat_2_gives_the_diffusivity_in_two_dimensions() {
    let domain = must(Domain::cuboid([("x", [0.0, PI]), ("y", [0.0, PI]), ("t", [0.0, 0.5])]));
    let [dx, dy, dt] = domain.derivatives();
    let theta = must(Parameter::new("theta", [0.02, 50.0]));
    let mut problem =
        must(Problem::new(domain.clone(), dt - &theta * (dx * dx) - &theta * (dy * dy)));
    for axis in ["x", "y"] {
        for side in Side::BOTH {
            problem = must(problem.condition(axis, side, Condition::Dirichlet(constant(0.0))));
        }
    }
    let start = field(|[x, y, _]: [Series; 3]| x.sin() * y.sin());
    problem = must(problem.condition("t", Side::Lower, Condition::Dirichlet(start)));
    let exact = |[x, y, t]: [f64; 3]| x.sin() * y.sin() * (-2.0 * t).exp();
    for seed in 0..seeds() {
        let prior = must(Prior::constrained(&problem, &squared_exponential()));
        let fit = fit(prior, observed(&domain, exact, [50, 50], 0.025, seed), seed);
        let err = error(&fit, &domain, exact);
        report("Heat 2", &fit, err, "theta");
        assert!(!fit.outcome().collapsed);
        assert!((must(fit.parameter("theta")) - 1.0).abs() < 0.05);
    }
}

/// u_t + θ u_x = diffusion u_xx, held at both ends, from sin(2πx) eˣ.
fn advection_and_diffusion(domain: &Domain<2>) -> Problem<2> {
    let [dx, dt] = domain.derivatives();
    let advection = must(Parameter::new("theta", [0.001, 2.0]));
    let diffusion = must(Parameter::new("diffusion", [0.001, 1.0]));
    let held = || Condition::Dirichlet(constant(0.0));
    let start = field(|[x, _]: [Series; 2]| (&x * (2.0 * PI)).sin() * x.exp());
    must(
        Problem::new(domain.clone(), dt + &advection * dx - &diffusion * (dx * dx))
            .and_then(|p| p.condition("x", Side::Lower, held()))
            .and_then(|p| p.condition("x", Side::Upper, held()))
            .and_then(|p| p.condition("t", Side::Lower, Condition::Dirichlet(start))),
    )
}

#[test]
fn advection_and_diffusion_are_told_apart() {
    let domain = must(Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])]));
    let problem = advection_and_diffusion(&domain);
    let exact = |[x, t]: [f64; 2]| (2.0 * PI * x).sin() * (-(0.1 * PI * PI + 0.025) * t + x).exp();
    for (count, label) in [(10, "Adv 1"), (25, "Adv 2"), (75, "Adv 3")] {
        for seed in 0..seeds() {
            let prior = must(Prior::constrained(&problem, &squared_exponential()));
            let fit = fit(prior, observed(&domain, exact, [count, count], 0.025, seed), seed);
            let err = error(&fit, &domain, exact);
            report(label, &fit, err, "theta");
            assert!(!fit.outcome().collapsed);
            assert!((must(fit.parameter("diffusion")) - 0.025).abs() < 0.01);
        }
    }
}

#[test]
fn helmholtz_mixes_conditions() {
    let domain = must(Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 1.0])]));
    let [dx, dy] = domain.derivatives();
    let mut problem =
        must(Problem::new(domain.clone(), -(dx * dx) - dy * dy + 9.0 * Derivative::identity()));
    for axis in ["x", "y"] {
        problem = must(problem.condition(axis, Side::Lower, Condition::Neumann(constant(0.0))));
        problem = must(problem.condition(axis, Side::Upper, Condition::Dirichlet(constant(0.0))));
    }
    let e = (-1.0_f64).exp();
    let exact = |[x, y]: [f64; 2]| {
        (1.0 - x * x) * (1.0 - y * y) + (PI * x / 2.0).cos() * ((-y).exp() + y - 1.0 - e)
    };
    let load = |[x, y]: [f64; 2]| {
        let bend = (-y).exp() + y - 1.0 - e;
        let cos = (PI * x / 2.0).cos();
        2.0 * (1.0 - x * x) + 2.0 * (1.0 - y * y) + PI * PI / 4.0 * cos * bend - cos * (-y).exp()
            + 9.0 * exact([x, y])
    };
    for seed in 0..seeds() {
        let noisy = |of: &dyn Fn([f64; 2]) -> f64, points: &[[f64; 2]], phase: f64| -> Vec<f64> {
            let error = |k: usize| 0.014 * (2.3 * k as f64 + phase + seed as f64).sin();
            points.iter().enumerate().map(|(k, x)| of(*x) + error(k)).collect()
        };
        let (places, at) = (must(domain.sample(10, seed)), must(domain.sample(10, seed + 500)));
        let data = Data::new()
            .values(&places, &noisy(&exact, &places, 0.3), Noise::Known(0.01))
            .equation(&at, &noisy(&load, &at, 1.1), Noise::Known(0.01));
        let prior = must(Prior::constrained(&problem, &squared_exponential()));
        let fit = fit(prior, data, seed);
        let err = error(&fit, &domain, exact);
        report("Helm 1", &fit, err, "theta");
        assert!(err < 6e-3, "{err:e}");
    }
}

/// −Δu = 4 with u = 0 on the regular pentagon: u at the centre and −∂u/∂n amid an edge, by harmonic
/// polynomials and poles (see the example `pentagon`).
const PENTAGON: [f64; 2] = [0.728_969_387_013, 2.061_258_750_772];

/// Even load on a polygon without values on its boundary, at random points.
fn membrane(corners: &[[f64; 2]], load: f64, count: usize) -> Fit<2> {
    let domain = must(Domain::polygon(["x", "y"], corners));
    let [dx, dy] = domain.derivatives();
    let problem = must(
        Problem::new(domain.clone(), -(dx * dx) - dy * dy).and_then(|p| p.boundary(constant(0.0))),
    );
    let at = must(domain.sample(count, 3));
    let data = Data::new().equation(&at, &vec![load; count], Noise::Exact);
    let prior = must(Prior::constrained(&problem, &squared_exponential()));
    let options = FitOptions {
        restarts: 2,
        iterations: 60,
        seed: 1,
        most_points: 0,
        ..FitOptions::default()
    };
    must(must(Model::new(prior, data, Evidence::Auto)).fit(&options))
}

/// −Δu = 1 with u = 0 on the unit square: u at its centre, by Fourier series.
const SQUARE: f64 = 0.073_671_353_281;

#[test]
fn polygons_are_solved_to_what_the_thesis_prints() {
    let corners: Vec<[f64; 2]> = (0..5)
        .map(|k| {
            let angle = PI / 2.0 + 2.0 * PI * f64::from(k) / 5.0;
            [angle.cos(), angle.sin()]
        })
        .collect();
    let conditional = must(membrane(&corners, 4.0, 100).conditional());
    let centre = must(conditional.mean(&[[0.0, 0.0]]))[0];
    let outwards = Operator::from(Derivative::along(1));
    let amid_an_edge = [0.0, -(0.2 * PI).cos()];
    let shear = must(conditional.predict_operator(&outwards, &[amid_an_edge])).mean[0];
    let [u, shear] = [(centre - PENTAGON[0]).abs(), (shear - PENTAGON[1]).abs()];
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let conditional = must(membrane(&corners, 1.0, 50).conditional());
    let square = (must(conditional.mean(&[[0.5, 0.5]]))[0] - SQUARE).abs();
    println!("Pentagon: u off by {u:.1e}, shear by {shear:.1e}; square: {square:.1e}");
    // The product of R-functions of the edges is smooth where the solution is not, at the corners: 2.5e-4, 1.1e-4 and 8.7e-5 with
    // these points. The thesis prints a mean error of 1.1e-3 on the pentagon.
    assert!(u < 5e-4 && shear < 2.5e-4 && square < 2e-4, "{u:e} {shear:e} {square:e}");
}

#[test]
fn one_value_of_the_equation_keeps_fits_from_collapse() {
    let domain = must(Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])]));
    let problem = advection_and_diffusion(&domain);
    let exact = |[x, t]: [f64; 2]| (2.0 * PI * x).sin() * (-(0.1 * PI * PI + 0.025) * t + x).exp();
    let fitted = |constrained: bool, seed: u64| {
        let kernel = squared_exponential();
        let prior = match constrained {
            true => Prior::constrained(&problem, &kernel),
            false => Prior::unconstrained(&problem, &kernel),
        };
        let data = observed(&domain, exact, [25, 25], 0.025, seed);
        let options = FitOptions { restarts: 4, seed, most_points: 0, ..FitOptions::default() };
        must(must(Model::new(must(prior), data, Evidence::Auto)).fit(&options))
    };
    for constrained in [true, false] {
        let fit = fitted(constrained, 0);
        assert_eq!(fit.model().evidence(), Evidence::UnitInformation);
        assert!(!fit.outcome().collapsed, "with conditions: {constrained}");
    }
}

/// Data sets per problem: more for a study by hand.
fn seeds() -> u64 {
    std::env::var("SINEW_GP_SEEDS").ok().and_then(|s| s.parse().ok()).unwrap_or(1)
}
