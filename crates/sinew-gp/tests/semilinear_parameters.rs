//! Unknown parameters inside a nonlinear term.

use sinew_gp::{
    Condition, Data, Derivative, Domain, Evidence, FitOptions, GpError, Noise, Parameter, Problem,
    SemiLinear, Side, SquaredExponential, VariationalOptions, constant, laplace,
};

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
    let term =
        |[u]: [sinew_gp::Series; 1], [r, c]: [sinew_gp::Series; 2]| -(r * &u * (1.0 - &u / c));
    Ok(SemiLinear::with_parameters(problem, [Derivative::identity()], [rate, capacity], term))
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
    let (growth, kernel) = (growth()?, SquaredExponential::new());
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
        assert!(lower < median && median < upper && (ensemble.mean(name)? - median).abs() < 0.1);
    }
    // The nonlinear equation holds between the points, with the parameters found.
    let between = growth.left_hand_side(&solution, &[[0.55], [1.3], [3.1]])?;
    assert!(between.iter().all(|miss| miss.abs() < 1e-3), "{between:?}");
    let off = solution.fit.posterior()?.mean(&[[1.3], [2.7]])?;
    assert!((off[0] - exact(1.3)).abs() < 0.02 && (off[1] - exact(2.7)).abs() < 0.02, "{off:?}");
    Ok(())
}

#[test]
fn the_variational_bound_keeps_the_terms_parameters() -> Result<(), GpError> {
    let (growth, kernel) = (growth()?, SquaredExponential::new());
    let data = measured(Noise::Known(0.01));
    let linear = growth.solve(&kernel, &data, &FitOptions::default(), 40)?;
    let bound = growth.variational(&linear, &kernel, &data, &VariationalOptions::default())?;
    let found = bound.predict(&[[1.3], [2.7]])?;
    for (mean, t) in found.mean.iter().zip([1.3, 2.7]) {
        assert!((mean - exact(t)).abs() < 0.02, "{mean} for {}", exact(t));
    }
    Ok(())
}

#[test]
fn samples_of_an_operator_scatter_as_predicted() -> Result<(), GpError> {
    let (growth, kernel) = (growth()?, SquaredExponential::new());
    let solution =
        growth.solve(&kernel, &measured(Noise::Known(0.05)), &FitOptions::default(), 40)?;
    let posterior = solution.fit.posterior()?;
    let rate = Derivative::along(0).into();
    let predicted = posterior.predict_operator(&rate, &[[1.7]])?;
    let samples = posterior.sample_operator(&rate, &[[1.7], [3.0]], 4000, 1)?;
    let first: Vec<f64> = samples.iter().map(|sample| sample[0]).collect();
    let mean = first.iter().sum::<f64>() / 4000.0;
    let spread = (first.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / 4000.0).sqrt();
    let expected = predicted.standard_deviation[0];
    // Four standard errors of mean and standard deviation.
    assert!((mean - predicted.mean[0]).abs() < 4.0 * expected / 4000.0_f64.sqrt());
    assert!((spread / expected - 1.0).abs() < 4.0 / 8000.0_f64.sqrt(), "{spread} {expected}");
    Ok(())
}
