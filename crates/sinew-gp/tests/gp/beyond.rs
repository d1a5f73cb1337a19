//! Parameter ensembles, nonlinear equations and hard cases.

use sinew_gp::{
    Condition, Data, Derivative, Domain, Evidence, FitOptions, GpError, Model, Noise, NutsOptions,
    Operator, Parameter, Prior, Problem, SemiLinear, Series, Side, constant, field, laplace, nuts,
    squared_exponential,
};
use std::f64::consts::PI;

fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// Asserts that an error says what is expected of it.
#[track_caller]
fn says(error: &GpError, text: &str) {
    assert!(error.to_string().contains(text), "{error}");
}

/// −u″ = f on [0, 1] with u = 0 at both ends, times a stiffness to be found.
fn string(unknown: bool) -> Problem<1> {
    string_within(unknown.then_some([0.05, 50.0]))
}

fn string_within(bounds: Option<[f64; 2]>) -> Problem<1> {
    let domain = must(Domain::interval("x", [0.0, 1.0]));
    let [dx] = domain.derivatives();
    let equation = match bounds {
        Some(bounds) => -(&must(Parameter::new("stiffness", bounds)) * dx * dx),
        None => -2.0 * (dx * dx),
    };
    let held = || Condition::Dirichlet(constant(0.0));
    must(
        Problem::new(domain, equation)
            .and_then(|p| p.condition("x", Side::Lower, held()))
            .and_then(|p| p.condition("x", Side::Upper, held())),
    )
}

/// u = sin πx / (2π²): what stiffness 2 makes of the load sin πx.
fn deflection([x]: [f64; 1]) -> f64 {
    (PI * x).sin() / (2.0 * PI * PI)
}

fn loads(count: usize) -> (Vec<[f64; 1]>, Vec<f64>) {
    let at: Vec<[f64; 1]> = (0..count).map(|k| [(k as f64 + 0.5) / count as f64]).collect();
    let f = at.iter().map(|[x]| (PI * x).sin()).collect();
    (at, f)
}

/// Six noisy deflections and ten loads.
fn measured() -> Data<1> {
    let (at, f) = loads(10);
    let places: Vec<[f64; 1]> = (1..7).map(|k| [f64::from(k) / 7.0]).collect();
    let y: Vec<f64> = places
        .iter()
        .enumerate()
        .map(|(k, x)| deflection(*x) + 0.0015 * (3.7 * k as f64 + 1.0).sin())
        .collect();
    Data::new().values(&places, &y, Noise::Known(0.001)).equation(&at, &f, Noise::Exact)
}

fn prior(problem: &Problem<1>) -> Prior<1> {
    must(Prior::constrained(problem, &squared_exponential()))
}

#[test]
fn ensembles_hold_the_truth_and_agree() {
    let model = must(Model::new(prior(&string(true)), measured(), Evidence::Auto));
    let fit = must(model.fit(&FitOptions::default()));
    let normal = must(laplace(&fit, 400, 1));
    let options = NutsOptions { warmup: 100, draws: 200, seed: 1 };
    let sampled = must(nuts(&fit, &options));
    for ensemble in [&normal, &sampled] {
        let [lower, upper] = must(ensemble.interval("stiffness", 0.95));
        println!("stiffness {} in [{lower}, {upper}]", must(fit.parameter("stiffness")));
        assert!(lower < 2.0 && 2.0 < upper, "[{lower}, {upper}]");
        // The noise of six values of size 0.05 leaves about one per cent.
        assert!(upper - lower > 0.02 && upper - lower < 0.3, "[{lower}, {upper}]");
        let prediction = must(ensemble.predict(&[[0.5], [0.0]]));
        assert!(
            (prediction.mean[0] - deflection([0.5])).abs() < 3.0 * prediction.standard_deviation[0]
        );
        assert_eq!(prediction.standard_deviation[1], 0.0);
    }
    let again = must(nuts(&fit, &options));
    assert_eq!(again.draws, sampled.draws, "a seed gives one answer");
}

#[test]
fn a_parameter_at_its_bound_has_an_interval() {
    // The truth, 2, is out of bounds by one standard deviation: what is probable begins at the bound.
    const BOUND: f64 = 2.02;
    let problem = string_within(Some([BOUND, 50.0]));
    let model = must(Model::new(prior(&problem), measured(), Evidence::Auto));
    let fit = must(model.fit(&FitOptions::default()));
    assert!((must(fit.parameter("stiffness")) - BOUND).abs() < 1e-9);
    let normal = must(laplace(&fit, 1000, 1));
    let sampled = must(nuts(&fit, &NutsOptions { warmup: 100, draws: 400, seed: 1 }));
    let widths = [normal, sampled].map(|ensemble| {
        let [lower, upper] = must(ensemble.interval("stiffness", 0.95));
        assert!(BOUND - 1e-9 <= lower && lower < upper, "[{lower}, {upper}]");
        upper - BOUND
    });
    println!(
        "stiffness from its bound on: {:.1e} by Laplace, {:.1e} by NUTS",
        widths[0], widths[1]
    );
    assert!((0.5..2.0).contains(&(widths[0] / widths[1])), "{widths:?}");
}

#[test]
fn only_what_is_far_from_the_data_has_collapsed() {
    // Nothing but noise: the least amplitude, and the noise that explains the rest.
    let collapsed = |end: f64, exact: fn(f64) -> f64| {
        let domain = must(Domain::interval("x", [0.0, 1.0]));
        let [dx] = domain.derivatives();
        let held = |value: f64| Condition::Dirichlet(constant(value));
        let problem = Problem::new(domain, -(dx * dx))
            .and_then(|p| p.condition("x", Side::Lower, held(0.0)))
            .and_then(|p| p.condition("x", Side::Upper, held(end)));
        let places: Vec<[f64; 1]> = (1..9).map(|k| [f64::from(k) / 9.0]).collect();
        let error = |k: usize| 0.02 * (3.7 * k as f64).sin();
        let numbered = places.iter().enumerate();
        let y: Vec<f64> = numbered.map(|(k, [x])| exact(*x) + error(k)).collect();
        let data = Data::new().values(&places, &y, Noise::Learned);
        let model = must(Model::new(prior(&must(problem)), data, Evidence::Joint));
        let start = model.parameters().iter().map(|p| match p.name.as_str() {
            "amplitude 1" => p.to_scale(p.bounds[0]),
            "noise 1" => p.to_scale(p.bounds[1]),
            _ => p.to_scale(p.start[1]),
        });
        let start = start.collect();
        must(model.fit_from(vec![start], 0)).outcome().collapsed
    };
    assert!(collapsed(0.0, |x| (PI * x).sin()), "a wave taken for noise");
    assert!(
        !collapsed(1.0, |x| x),
        "the prior mean is the solution, and nothing is left to explain"
    );
}

#[test]
fn allen_cahn_front_by_gauss_newton() {
    // −ε² u″ + u³ − u = 0 with the front u = tanh(x / (√2 ε)).
    const EPSILON: f64 = 0.2;
    let exact = |x: f64| (x / (2.0_f64.sqrt() * EPSILON)).tanh();
    let domain = must(Domain::interval("x", [-1.0, 1.0]));
    let [dx] = domain.derivatives();
    let end = exact(1.0);
    let linear = must(
        Problem::new(domain.clone(), -EPSILON * EPSILON * (dx * dx))
            .and_then(|p| p.condition("x", Side::Lower, Condition::Dirichlet(constant(-end))))
            .and_then(|p| p.condition("x", Side::Upper, Condition::Dirichlet(constant(end)))),
    );
    let front = SemiLinear::new(linear, [Derivative::identity()], |[u]| u.powi(3) - u);
    let at: Vec<[f64; 1]> = (0..40).map(|k| [-1.0 + (f64::from(k) + 0.5) / 20.0]).collect();
    let data = Data::new().equation(&at, &[0.0; 40], Noise::Exact);
    let solution = must(front.solve(&squared_exponential(), &data, &FitOptions::default(), 30));
    let grid = domain.grid(101);
    let mean = must(must(solution.fit.conditional()).mean(&grid));
    let err = mean.iter().zip(&grid).map(|(m, [x])| (m - exact(*x)).abs()).fold(0.0, f64::max);
    println!(
        "front: {} steps, change {:.1e}, largest error {err:.1e}",
        solution.steps, solution.change
    );
    assert!(err < 1e-4, "{err:e}");
}

#[test]
fn burgers_gives_the_viscosity() {
    // u = 2 ν π e^{−π²νt} sin πx / (2 + e^{−π²νt} cos πx) solves u_t + u u_x = ν u_xx (Cole–Hopf).
    const NU: f64 = 0.1;
    let exact = |[x, t]: [f64; 2]| {
        let decay = (-PI * PI * NU * t).exp();
        2.0 * NU * PI * decay * (PI * x).sin() / (2.0 + decay * (PI * x).cos())
    };
    let domain = must(Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])]));
    let [dx, dt] = domain.derivatives();
    let viscosity = must(Parameter::new("viscosity", [0.01, 1.0]));
    let held = || Condition::Dirichlet(constant(0.0));
    let start = field(|[x, _]: [Series; 2]| {
        let angle = x * PI;
        angle.sin() * (2.0 * NU * PI) / (angle.cos() + 2.0)
    });
    let linear = must(
        Problem::new(domain.clone(), dt - &viscosity * dx * dx)
            .and_then(|p| p.condition("x", Side::Lower, held()))
            .and_then(|p| p.condition("x", Side::Upper, held()))
            .and_then(|p| p.condition("t", Side::Lower, Condition::Dirichlet(start))),
    );
    let burgers = SemiLinear::new(linear, [Derivative::identity(), dx], |[u, slope]| u * slope);
    let places = must(domain.sample(20, 4));
    let y: Vec<f64> = places
        .iter()
        .enumerate()
        .map(|(k, x)| exact(*x) + 0.002 * (2.9 * k as f64).sin())
        .collect();
    let at = must(domain.sample(40, 5));
    let data =
        Data::new().values(&places, &y, Noise::Learned).equation(&at, &[0.0; 40], Noise::Exact);
    let solution = must(burgers.solve(&squared_exponential(), &data, &FitOptions::default(), 15));
    let nu = must(solution.fit.parameter("viscosity"));
    println!("Burgers: ν {nu:.4} in {} steps, change {:.1e}", solution.steps, solution.change);
    assert!((nu / NU - 1.0).abs() < 0.05, "{nu}");
}

#[test]
fn hard_cases_are_right_or_typed_errors() {
    let problem = string(false);
    let (at, f) = loads(6);
    let solve = |data: Data<1>| {
        Model::new(prior(&problem), data, Evidence::Auto)
            .and_then(|model| model.fit(&FitOptions { restarts: 2, ..FitOptions::default() }))
            .and_then(|fit| fit.conditional())
            .and_then(|conditional| conditional.mean(&[[0.5]]))
    };
    let base = Data::new().equation(&at, &f, Noise::Exact);
    let close = |mean: Vec<f64>, tolerance: f64| {
        assert!((mean[0] - deflection([0.5])).abs() < tolerance, "{mean:?}");
    };
    // Every observation twice, without noise: the jitter takes it.
    let twice = base.clone().equation(&at, &f, Noise::Exact);
    close(must(solve(twice)), 1e-4);
    // Exact values on the boundary say nothing; wrong ones are refused.
    close(
        must(solve(base.clone().values(&[[0.0], [0.3]], &[0.0, deflection([0.3])], Noise::Exact))),
        1e-4,
    );
    let wrong = solve(base.clone().values(&[[1.0]], &[0.2], Noise::Exact)).unwrap_err();
    says(&wrong, "value 0 of observation group 2 is noise-free and off by 0.2");
    // One observation only.
    let one = must(solve(Data::new().values(&[[0.5]], &[deflection([0.5])], Noise::Exact)));
    close(one, 1e-6);
    // NaN and empty input are named.
    let nan = solve(base.clone().values(&[[0.4]], &[f64::NAN], Noise::Learned)).unwrap_err();
    says(&nan, "value number 0 of observation group 2 is NaN");
    says(&solve(Data::new()).unwrap_err(), "no observations");
    let lengths = solve(base.clone().values(&[[0.4]], &[], Noise::Learned)).unwrap_err();
    says(&lengths, "1 points but 0 values");
    let noise = solve(base.values(&[[0.4]], &[0.1], Noise::Known(0.0))).unwrap_err();
    says(&noise, "noise of standard deviation 0e0;");
}

#[test]
fn units_do_not_matter() {
    // The same string measured in micrometres, deflections in millions.
    let fit_in = |length: f64, size: f64| {
        let domain = must(Domain::interval("x", [0.0, length]));
        let [dx] = domain.derivatives();
        let held = || Condition::Dirichlet(constant(0.0));
        let problem = must(
            Problem::new(domain, -2.0 * (dx * dx))
                .and_then(|p| p.condition("x", Side::Lower, held()))
                .and_then(|p| p.condition("x", Side::Upper, held())),
        );
        let (at, f) = loads(7);
        let at: Vec<[f64; 1]> = at.iter().map(|[x]| [x * length]).collect();
        let f: Vec<f64> = f.iter().map(|f| f * size / (length * length)).collect();
        let data = Data::new().equation(&at, &f, Noise::Exact);
        let fit = must(
            must(Model::new(prior(&problem), data, Evidence::Auto)).fit(&FitOptions::default()),
        );
        must(must(fit.conditional()).mean(&[[0.5 * length]]))[0] / size
    };
    for (length, size) in [(1.0, 1.0), (1e6, 1.0), (1e-6, 1e6), (1.0, 1e-6)] {
        let middle = fit_in(length, size);
        assert!((middle - deflection([0.5])).abs() < 1e-6, "{length} {size}: {middle}");
    }
}

#[test]
fn fluxes_and_samples_follow_the_posterior() {
    let model = must(Model::new(prior(&string(true)), measured(), Evidence::Auto));
    let fit = must(model.fit(&FitOptions::default()));
    let conditional = must(fit.conditional());
    let slope = Operator::from(Derivative::along(0));
    let at_end = must(conditional.predict_operator(&slope, &[[0.0]]));
    assert!((at_end.mean[0] - 1.0 / (2.0 * PI)).abs() < 0.01);
    let places = [[0.0], [0.3], [0.6]];
    let prediction = must(conditional.predict(&places));
    let draws = must(conditional.sample(&places, 2000, 5));
    for (place, deviation) in prediction.standard_deviation.iter().enumerate() {
        let mean = draws.iter().map(|d| d[place]).sum::<f64>() / 2000.0;
        let variance = draws.iter().map(|d| (d[place] - mean).powi(2)).sum::<f64>() / 2000.0;
        assert!((variance.sqrt() - deviation).abs() < 0.1 * deviation + 1e-7);
    }
}
