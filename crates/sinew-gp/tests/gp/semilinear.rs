//! Nonlinear equations by linearisation: terms of several arguments, with unknown parameters, and without a value.

use sinew_gp::{
    Condition, Data, Derivative, Domain, Evidence, FitOptions, GpError, Noise, Parameter, Problem,
    SemiLinear, Series, Side, Warning, constant, field, laplace, squared_exponential,
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

/// A string: −u″ = f on [0, 1], held at both ends.
fn string() -> Problem<1> {
    let domain = must(Domain::interval("x", [0.0, 1.0]));
    let [dx] = domain.derivatives();
    let held = || Condition::Dirichlet(constant(0.0));
    must(
        Problem::new(domain, -(dx * dx))
            .and_then(|p| p.condition("x", Side::Lower, held()))
            .and_then(|p| p.condition("x", Side::Upper, held())),
    )
}

#[test]
fn terms_without_a_value_are_named_by_point_and_arguments() {
    let kernel = squared_exponential();
    let options = FitOptions { restarts: 1, ..FitOptions::default() };
    let data = Data::new().equation(&[[0.2], [0.5]], &[1.0; 2], Noise::Exact);
    let identity = [Derivative::identity()];
    // Of the prior mean, zero, the logarithm has no value and the root no slope.
    for term in [|[u]: [Series; 1]| u.ln(), |[u]: [Series; 1]| u.sqrt()] {
        let equation = SemiLinear::new(string(), identity, term);
        let named = equation.solve(&kernel, &data, &options, 5).unwrap_err();
        says(&named, "near (0), its arguments at point 0");
    }
    let cubic = SemiLinear::new(string(), identity, |[u]| u.powi(3));
    let solution = must(cubic.solve(&kernel, &data, &options, 9));
    assert!(solution.has_converged());
    let logarithm = SemiLinear::new(string(), identity, |[u]| u.ln());
    let ends = [[0.5], [0.0]];
    let named = logarithm.left_hand_side(&solution, &ends).unwrap_err();
    says(&named, "near (0), its arguments at point 1");
    // Unusable data come before anything that they are put into.
    let nowhere = Data::new().equation(&[[f64::NAN]], &[1.0], Noise::Exact);
    let named = logarithm.solve(&kernel, &nowhere, &options, 5).unwrap_err();
    says(&named, "point number 0 of observation group 1 is NaN");
    // −u″ − 6 eᵘ = 2 has no solution, and steps lead nowhere.
    let bratu = SemiLinear::new(string(), identity, |[u]| u.exp() * -6.0);
    let at: Vec<[f64; 1]> = (1..8).map(|k| [f64::from(k) / 8.0]).collect();
    let load = Data::new().equation(&at, &[2.0; 7], Noise::Learned);
    let lost = must(bratu.solve(&kernel, &load, &options, 10));
    assert!(!lost.has_converged(), "{}", lost.change);
}

/// u_t + u u_x − ν u_xx = 0 on [0, 1] × [0, 1] with a known solution (Cole & Hopf), ν unknown.
fn burgers() -> (Domain<2>, SemiLinear<2, 2>, impl Fn([f64; 2]) -> f64) {
    const NU: f64 = 0.1;
    let domain = must(Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])]));
    let [dx, dt] = domain.derivatives();
    let viscosity = must(Parameter::new("viscosity", [0.01, 1.0]));
    let held = || Condition::Dirichlet(constant(0.0));
    let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| {
        let angle = x * PI;
        angle.sin() * (2.0 * NU * PI) / (angle.cos() + 2.0)
    }));
    let linear = must(
        Problem::new(domain.clone(), dt - &viscosity * dx * dx)
            .and_then(|p| p.condition("x", Side::Lower, held()))
            .and_then(|p| p.condition("x", Side::Upper, held()))
            .and_then(|p| p.condition("t", Side::Lower, start)),
    );
    let exact = |[x, t]: [f64; 2]| {
        let decay = (-NU * PI * PI * t).exp();
        2.0 * NU * PI * decay * (PI * x).sin() / (2.0 + decay * (PI * x).cos())
    };
    let term = SemiLinear::new(linear, [Derivative::identity(), dx], |[u, slope]| u * slope);
    (domain, term, exact)
}

#[test]
fn terms_of_two_arguments_are_linearised_in_both() {
    let (domain, burgers, exact) = burgers();
    let places = must(domain.sample(20, 4));
    let y: Vec<f64> = (places.iter().enumerate())
        .map(|(k, x)| exact(*x) + 0.002 * (2.9 * k as f64).sin())
        .collect();
    let at = must(domain.sample(40, 5));
    let data =
        Data::new().values(&places, &y, Noise::Learned).equation(&at, &[0.0; 40], Noise::Learned);
    let solution = must(burgers.solve(&squared_exponential(), &data, &FitOptions::default(), 15));
    let grid = domain.grid(20);
    let mean = must(must(solution.fit.conditional()).mean(&grid));
    let error = mean.iter().zip(&grid).map(|(u, x)| (u - exact(*x)).abs()).sum::<f64>() / 400.0;
    let nu = must(solution.fit.parameter("viscosity"));
    println!("Burgers: ν {nu:.4}, err_u {error:.1e} after {} steps", solution.steps);
    assert!((nu / 0.1 - 1.0).abs() < 0.05 && error < 1e-3, "{nu} {error:e}");
}

/// Growth to a capacity c = 2 at a rate r = 1.5 from ¼: u = c / (1 + 7 exp(−r t)).
fn exact(t: f64) -> f64 {
    2.0 / (1.0 + 7.0 * (-1.5 * t).exp())
}

fn growth() -> Result<SemiLinear<1, 1>, GpError> {
    let domain = Domain::interval("t", [0.0, 4.0])?;
    let [dt] = domain.derivatives();
    let (rate, capacity) = (Parameter::new("r", [0.1, 10.0])?, Parameter::new("c", [0.5, 20.0])?);
    let start = Condition::Dirichlet(constant(0.25));
    let problem = Problem::new(domain, dt)?.condition("t", Side::Lower, start)?;
    let term = |[u]: [Series; 1], [r, c]: [Series; 2], _: [f64; 1]| -(r * &u * (1.0 - &u / c));
    Ok(SemiLinear::with_coordinates(problem, [Derivative::identity()], [rate, capacity], term))
}

fn measured(noise: Noise) -> Data<1> {
    let places: Vec<[f64; 1]> = (1..=20).map(|k| [0.2 * f64::from(k)]).collect();
    let error = |k: usize| 0.02 * (5.0 * (k as f64 + 0.3).sin()).sin();
    let y: Vec<f64> = places.iter().enumerate().map(|(k, [t])| exact(*t) + error(k)).collect();
    let at: Vec<[f64; 1]> = (0..25).map(|k| [4.0 * f64::from(k) / 24.0]).collect();
    Data::new().values(&places, &y, Noise::Learned).equation(&at, &[0.0; 25], noise)
}

#[test]
fn rate_and_capacity_of_a_growth_are_found() -> Result<(), GpError> {
    let (growth, kernel) = (growth()?, squared_exponential());
    let solution = growth.solve(&kernel, &measured(Noise::Exact), &FitOptions::default(), 40)?;
    assert!(solution.has_converged(), "{} after {}", solution.change, solution.steps);
    assert_eq!(solution.fit.model().evidence(), Evidence::UnitInformation);
    let ensemble = laplace(&solution.fit, 300, 1)?;
    for (name, truth) in [("r", 1.5), ("c", 2.0)] {
        let [lower, upper] = ensemble.interval(name, 0.95)?;
        let (found, median) = (solution.fit.parameter(name)?, ensemble.median(name)?);
        println!("{name} = {found:.4} (median {median:.4}) in {lower:.4} to {upper:.4}");
        assert!(lower < truth && truth < upper, "{name}: {lower} {upper}");
        assert!(upper - lower < 0.25 * truth, "{name}: {lower} {upper}");
        assert!(lower < median && median < upper);
    }
    // The nonlinear equation holds between the points, with the parameters found.
    let between = growth.left_hand_side(&solution, &[[0.55], [1.3], [3.1]])?;
    assert!(between.iter().all(|miss| miss.abs() < 1e-3), "{between:?}");
    let off = solution.fit.conditional()?.mean(&[[1.3], [2.7]])?;
    assert!((off[0] - exact(1.3)).abs() < 0.02 && (off[1] - exact(2.7)).abs() < 0.02, "{off:?}");
    Ok(())
}

#[test]
fn samples_scatter_as_predicted() -> Result<(), GpError> {
    let (growth, kernel) = (growth()?, squared_exponential());
    let solution =
        growth.solve(&kernel, &measured(Noise::Known(0.05)), &FitOptions::default(), 40)?;
    let conditional = solution.fit.conditional()?;
    let predicted = conditional.predict(&[[1.7]])?;
    let samples = conditional.sample(&[[1.7], [3.0]], 4000, 1)?;
    let first: Vec<f64> = samples.iter().map(|sample| sample[0]).collect();
    let mean = first.iter().sum::<f64>() / 4000.0;
    let spread = (first.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / 4000.0).sqrt();
    let expected = predicted.standard_deviation[0];
    // Four standard errors of mean and standard deviation.
    assert!((mean - predicted.mean[0]).abs() < 4.0 * expected / 4000.0_f64.sqrt());
    assert!((spread / expected - 1.0).abs() < 4.0 / 8000.0_f64.sqrt(), "{spread} {expected}");
    Ok(())
}

#[test]
fn terms_depend_on_the_place() -> Result<(), GpError> {
    let (kernel, options) = (squared_exponential(), FitOptions::default());
    let at: Vec<[f64; 1]> = (0..15).map(|k| [(f64::from(k) + 0.5) / 15.0]).collect();
    // −u″ = exp(−a x) with a = 2, from eight deflections: u = (1 − x + x e⁻² − e⁻²ˣ)/4.
    let absorption = Parameter::new("a", [0.2, 20.0])?;
    let heated = SemiLinear::with_coordinates(
        string(),
        [Derivative::identity()],
        [absorption],
        |_, [a], [x]| -(a * -x).exp(),
    );
    let exact = |x: f64| 0.25 * (1.0 - x + x * (-2.0_f64).exp() - (-2.0 * x).exp());
    let places: Vec<[f64; 1]> = (1..9).map(|k| [f64::from(k) / 9.0]).collect();
    let y: Vec<f64> = places.iter().map(|[x]| exact(*x)).collect();
    let data =
        Data::new().values(&places, &y, Noise::Known(1e-4)).equation(&at, &[0.0; 15], Noise::Exact);
    let solution = heated.solve(&kernel, &data, &options, 20)?;
    let found = solution.fit.parameter("a")?;
    println!("a {found:.4}");
    assert!(solution.has_converged() && (found - 2.0).abs() < 0.02, "{found}");
    // −u″ + (1 + x) u² = f for u = sin πx.
    let graded =
        SemiLinear::with_coordinates(string(), [Derivative::identity()], [], |[u], [], [x]| {
            u.squared() * (1.0 + x)
        });
    let load = |x: f64| {
        let u = (PI * x).sin();
        PI * PI * u + (1.0 + x) * u * u
    };
    let f: Vec<f64> = at.iter().map(|[x]| load(*x)).collect();
    let data = Data::new().equation(&at, &f, Noise::Exact);
    let solution = graded.solve(&kernel, &data, &options, 20)?;
    let middle = solution.fit.conditional()?.mean(&[[0.5]])?[0];
    assert!(solution.has_converged() && (middle - 1.0).abs() < 1e-4, "{middle}");
    Ok(())
}

#[test]
fn an_equation_everywhere_finds_its_points() -> Result<(), GpError> {
    // −u″ + (1 + x) u² = f for u = sin 5πx, which fifteen points at random do not tell.
    let (kernel, options) = (squared_exponential(), FitOptions::default());
    let wave = |x: &Series| (x * (5.0 * PI)).sin();
    let load = field(move |[x]: [Series; 1]| {
        let u = wave(&x);
        &u * (25.0 * PI * PI) + u.squared() * (x + 1.0)
    });
    let graded =
        SemiLinear::with_coordinates(string(), [Derivative::identity()], [], |[u], [], [x]| {
            u.squared() * (1.0 + x)
        });
    let data = Data::new().equation_everywhere(load.clone());
    let largest = |solution: &sinew_gp::Solution<1>| -> Result<f64, GpError> {
        let grid = Domain::interval("x", [0.0, 1.0])?.grid(101);
        let mean = solution.fit.conditional()?.mean(&grid)?;
        let off = mean.iter().zip(&grid).map(|(u, [x])| (u - (5.0 * PI * x).sin()).abs());
        Ok(off.fold(0.0, f64::max))
    };
    let few = FitOptions { most_points: 15, ..options };
    let rough = graded.solve(&kernel, &data, &few, 20)?;
    let solution = graded.solve(&kernel, &data, &options, 20)?;
    let (rough_off, off) = (largest(&rough)?, largest(&solution)?);
    println!("off by {off:.1e} where 15 points are off by {rough_off:.1e}");
    assert!(solution.has_converged() && off < 1e-3 && off < 0.2 * rough_off, "{off} {rough_off}");
    assert!(rough.fit.warnings()?.iter().any(|w| matches!(w, Warning::Unsettled { .. })));
    assert!(!solution.fit.warnings()?.iter().any(|w| matches!(w, Warning::Unsettled { .. })));
    Ok(())
}
