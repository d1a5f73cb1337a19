//! Parameters that data tell, and those that they do not: found, or said to be unidentified with the interval of the prior.

use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sinew_gp::{
    Condition, Data, Derivative, Domain, Evidence, Fit, FitOptions, GpError, Model, Noise,
    Parameter, Prior, Problem, Series, Side, constant, field, squared_exponential,
};
use sinew_sample::standard_normals;
use std::f64::consts::PI;

fn fitted<const D: usize>(problem: &Problem<D>, data: Data<D>) -> Result<Fit<D>, GpError> {
    let prior = Prior::constrained(problem, &squared_exponential())?;
    let options = FitOptions { most_points: if D == 1 { 200 } else { 0 }, ..FitOptions::default() };
    Model::new(prior, data, Evidence::Auto)?.fit(&options)
}

/// `count` values of u at random places with errors.
fn values<const D: usize>(
    domain: &Domain<D>,
    (count, seed): (usize, u64),
    u: impl Fn([f64; D]) -> f64,
    sigma: f64,
) -> Result<Data<D>, GpError> {
    let at = domain.sample(count, seed)?;
    let errors = standard_normals(count, &mut ChaCha8Rng::seed_from_u64(seed + 9000));
    let y: Vec<f64> = at.iter().zip(errors).map(|(x, e)| u(*x) + sigma * e).collect();
    Ok(Data::new().values(&at, &y, Noise::Learned))
}

#[test]
fn the_number_of_waves_is_found() -> Result<(), GpError> {
    // u″ + k² u = 0 on [0, 2] with u = 4 sin(kx + φ), 60 values with errors of 5 %, k² over four decades.
    let line = Domain::interval("x", [0.0, 2.0])?;
    let [dx] = line.derivatives();
    let square = Parameter::new("k2", [0.3, 3e3])?;
    let problem = Problem::new(line.clone(), dx * dx + &square * Derivative::identity())?;
    let mut found = 0;
    for (set, waves) in [0.9, 1.4, 1.9, 2.3, 2.8, 3.3, 3.7, 4.2, 4.6, 5.1].into_iter().enumerate() {
        let (k, phase) = (PI * waves, 0.7 * set as f64);
        let data = values(&line, (60, set as u64), |[x]| 4.0 * (k * x + phase).sin(), 0.14)?;
        let fit = fitted(&problem, data.equation_everywhere(constant(0.0)))?;
        let off = fit.parameter("k2")? / (k * k) - 1.0;
        println!("{waves} waves: off by {:.2} %", 100.0 * off);
        found += usize::from(off.abs() < 0.02);
    }
    assert!(found >= 9, "{found} of 10");
    Ok(())
}

#[test]
fn the_number_of_waves_between_ends_that_are_held_is_found() -> Result<(), GpError> {
    // u″ + k² u = 0 with u = sin nπx, 60 values with errors of 5 %.
    let line = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = line.derivatives();
    let square = Parameter::new("k2", [1.0, 1e4])?;
    let held = || Condition::Dirichlet(constant(0.0));
    let problem = Problem::new(line.clone(), dx * dx + &square * Derivative::identity())?
        .condition("x", Side::Lower, held())?
        .condition("x", Side::Upper, held())?;
    let mut found = 0;
    for set in 0..10 {
        let k = PI * (set + 1) as f64;
        let data = values(&line, (60, set), |[x]| (k * x).sin(), 0.05)?;
        let fit = fitted(&problem, data.equation_everywhere(constant(0.0)))?;
        let off = fit.parameter("k2")? / (k * k) - 1.0;
        println!("{} half waves: off by {:.2} %", set + 1, 100.0 * off);
        found += usize::from(off.abs() < 0.02);
    }
    assert!(found >= 9, "{found} of 10");
    Ok(())
}

#[test]
fn sizes_whose_squares_are_no_numbers_are_refused() -> Result<(), GpError> {
    let line = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = line.derivatives();
    let problem = Problem::new(line, &Parameter::new("a", [0.1, 10.0])? * dx * dx)?;
    let known = |size: f64| Noise::Known(1e-3 * size);
    for (size, noise) in [
        (1e160, Noise::Learned),
        (-1e300, Noise::Learned),
        (1e-170, Noise::Learned),
        (1e-150, known(1e-150)),
        // The square of the error vanishes, and those of the values.
        (1e-300, known(1e-300)),
    ] {
        let places = [[0.2], [0.4], [0.5], [0.8]];
        let data = Data::new().values(&places, &[1.0, 3.0, 4.0, 2.0].map(|y| y * size), noise);
        let refused = fitted(&problem, data.equation(&[[0.3]], &[0.0], Noise::Exact)).unwrap_err();
        assert!(matches!(refused, GpError::Invalid(_)), "{refused}");
        assert!(
            refused.to_string().contains("give values, conditions and coordinates"),
            "{refused}"
        );
    }
    for length in [1e-150, 1e100] {
        let line = Domain::interval("x", [0.0, length])?;
        let [dx] = line.derivatives();
        let problem = Problem::new(line, &Parameter::new("a", [0.1, 10.0])? * dx * dx)?;
        let data = Data::new().values(&[[0.2 * length], [0.4 * length]], &[1.0, 2.0], known(1.0));
        let refused = fitted(&problem, data.equation(&[[0.3 * length]], &[0.0], Noise::Exact));
        let refused = refused.unwrap_err().to_string();
        assert!(refused.contains("give coordinates in a unit"), "{refused}");
    }
    Ok(())
}

/// Asserts that a parameter is said to be unidentified, with the bounds of its prior.
#[track_caller]
fn is_unidentified<const D: usize>(fit: &Fit<D>, names: &[&str]) -> Result<(), GpError> {
    let printed = fit.to_string();
    println!("{printed}");
    for name in names {
        let parameter = &fit.model().parameters()[fit.model().position(name)?];
        assert_eq!(fit.interval(name, 0.95)?, parameter.bounds, "{printed}");
        assert!(!fit.ensemble()?.identifies(name)?);
        assert!(printed.contains(&format!("{name} unidentified")), "{printed}");
    }
    assert!(!printed.contains("report"), "{printed}");
    Ok(())
}

#[test]
fn a_sealed_slab_at_rest_has_no_diffusivity() -> Result<(), GpError> {
    let domain = Domain::cuboid([("x", [0.0, 2.0]), ("t", [0.0, 3.0])])?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.02, 5.0])?;
    let sealed = || Condition::Neumann(constant(0.0));
    let problem = Problem::new(domain.clone(), dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, sealed())?
        .condition("x", Side::Upper, sealed())?
        .condition("t", Side::Lower, Condition::Dirichlet(constant(2.0)))?;
    for seed in 0..3 {
        let data = values(&domain, (20, seed), |_| 2.0, 0.05)?;
        let at = domain.sample(25, seed + 70)?;
        is_unidentified(&fitted(&problem, data.equation(&at, &[0.0; 25], Noise::Exact))?, &["D"])?;
    }
    Ok(())
}

#[test]
fn one_exponential_does_not_tell_two_rates() -> Result<(), GpError> {
    // u″ + c u′ + k u = 0 holds for u = e^−t wherever k = c − 1.
    let time = Domain::interval("t", [0.0, 3.0])?;
    let [dt] = time.derivatives();
    let (c, k) = (Parameter::new("c", [0.1, 10.0])?, Parameter::new("k", [0.1, 10.0])?);
    let problem = Problem::new(time.clone(), dt * dt + &c * dt + &k * Derivative::identity())?;
    for seed in 0..2 {
        let data = values(&time, (30, seed), |[t]| 2.0 * (-t).exp(), 0.04)?;
        let at = time.sample(20, seed + 70)?;
        let fit = fitted(&problem, data.equation(&at, &[0.0; 20], Noise::Exact))?;
        is_unidentified(&fit, &["c", "k"])?;
    }
    Ok(())
}

#[test]
fn the_tail_of_a_decay_does_not_tell_its_rate() -> Result<(), GpError> {
    // u′ + k u = 0 with u = e^−6t, measured where it is a hundredth of the errors and less, with the start known and without.
    let time = Domain::interval("t", [0.0, 3.0])?;
    let [dt] = time.derivatives();
    let rate = Parameter::new("k", [0.02, 200.0])?;
    let decay = Problem::new(time.clone(), dt + &rate * Derivative::identity())?;
    let start = Condition::Dirichlet(constant(1.0));
    let started = decay.clone().condition("t", Side::Lower, start)?;
    let tail = Domain::interval("t", [1.6, 3.0])?;
    for (problem, seed) in [(&decay, 0), (&decay, 1), (&started, 2), (&started, 3)] {
        let data = values(&tail, (25, seed), |[t]| (-6.0 * t).exp(), 0.03)?;
        is_unidentified(&fitted(problem, data.equation_everywhere(constant(0.0)))?, &["k"])?;
    }
    Ok(())
}

/// u_t = D u_xx − k u with both ends held.
fn reaction(
    start: impl Fn(Series) -> Series + Send + Sync + 'static,
) -> Result<Problem<2>, GpError> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = domain.derivatives();
    let (d, k) = (Parameter::new("D", [0.01, 10.0])?, Parameter::new("k", [0.01, 10.0])?);
    let held = || Condition::Dirichlet(constant(0.0));
    Problem::new(domain, dt - &d * dx * dx + &k * Derivative::identity())?
        .condition("x", Side::Lower, held())?
        .condition("x", Side::Upper, held())?
        .condition("t", Side::Lower, Condition::Dirichlet(field(move |[x, _]| start(x))))
}

fn mode(n: f64, [x, t]: [f64; 2]) -> f64 {
    (n * PI * x).sin() * (-(0.1 * (n * PI).powi(2) + 1.0) * t).exp()
}

#[test]
fn two_modes_tell_diffusivity_and_reaction_and_one_does_not() -> Result<(), GpError> {
    let one = reaction(|x| (x * PI).sin())?;
    let two = reaction(|x| (&x * PI).sin() + (x * (2.0 * PI)).sin())?;
    for (problem, is_told) in [(one, false), (two, true)] {
        let domain = problem.domain();
        let u = |x| mode(1.0, x) + if is_told { mode(2.0, x) } else { 0.0 };
        let data = values(domain, (24, 3), u, 0.02)?;
        let at = domain.sample(24, 73)?;
        let fit = fitted(&problem, data.equation(&at, &[0.0; 24], Noise::Exact))?;
        if !is_told {
            is_unidentified(&fit, &["D", "k"])?;
            continue;
        }
        println!("{fit}");
        for (name, truth) in [("D", 0.1), ("k", 1.0)] {
            let [lower, upper] = fit.interval(name, 0.99)?;
            assert!(fit.ensemble()?.identifies(name)?, "{fit}");
            assert!(lower < truth && truth < upper && upper < 3.0 * lower, "{fit}");
        }
    }
    Ok(())
}
