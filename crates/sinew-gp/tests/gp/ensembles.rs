//! Predictions over draws of the parameters against sums by hand, and draws against the posterior by quadrature.

use sinew_gp::{
    Condition, Conditional, Data, Derivative, Domain, Ensemble, Evidence, Fit, FitOptions, Formula,
    Functional, GpError, Hyperprior, Model, Noise, Operator, Parameter, Prior, Problem, Series,
    Side, constant, laplace, squared_exponential,
};

/// D u″ = −1 with u(0) = 0, fitted to data, and an ensemble; the operator of the flux D u′.
fn spring(data: Data<1>) -> Result<(Fit<1>, Ensemble<1>, Operator<1>), GpError> {
    let domain = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = domain.derivatives();
    let stiffness = Parameter::new("D", [0.1, 10.0])?;
    let problem = Problem::new(domain, &stiffness * dx * dx)?.condition(
        "x",
        Side::Lower,
        Condition::Dirichlet(constant(0.0)),
    )?;
    let prior = Prior::constrained(&problem, &squared_exponential())?;
    let data = data.equation(&[[0.2], [0.6]], &[-1.0; 2], Noise::Exact);
    let model = Model::new(prior, data, Evidence::Joint)?;
    let start = model.parameters().iter().map(|p| p.to_scale((p.start[0] * p.start[1]).sqrt()));
    let start = start.collect();
    let fit = model.fit_from(vec![start], 100)?;
    let ensemble = laplace(&fit, 100, 1)?;
    Ok((fit, ensemble, &stiffness * dx))
}

#[test]
fn an_operators_parameters_are_those_of_each_draw() -> Result<(), GpError> {
    let measured = Data::new().values(&[[0.3], [0.8]], &[0.2, 0.4], Noise::Known(0.01));
    let (fit, mut ensemble, flux) = spring(measured)?;
    let model = fit.model();
    // Two draws whose D are far apart.
    let position = model.position("D")?;
    let draws = [0.3, 3.0].map(|value| {
        let mut draw = vec![0.0; model.parameters().len()];
        draw[position] = model.parameters()[position].to_scale(value);
        draw
    });
    ensemble.draws = draws.to_vec();
    let values = ensemble.parameter("D")?;
    assert!((values[0] - 0.3).abs() < 1e-12 && (values[1] - 3.0).abs() < 1e-12);
    // By hand: the slope under each draw times its D.
    let slope: Operator<1> = Derivative::<1>::along(0).into();
    let members: Vec<(f64, f64)> = std::iter::zip(&ensemble.draws, &values)
        .map(|(draw, stiffness)| {
            let conditional = Conditional::new(model.clone(), draw)?;
            let slope = conditional.predict_operator(&slope, &[[0.9]])?;
            Ok((stiffness * slope.mean[0], stiffness * slope.standard_deviation[0]))
        })
        .collect::<Result<_, GpError>>()?;
    let [(a, s), (b, t)] = [members[0], members[1]];
    let mean = 0.5 * (a + b);
    let deviation = (0.5 * (s * s + t * t) + 0.25 * (a - b).powi(2)).sqrt();
    assert!((a - b).abs() > 0.1 * deviation, "the draws differ: {members:?}");
    // Rounding of a well-conditioned 4 × 4 solution.
    const TOLERANCE: f64 = 1e-9;
    let found = ensemble.predict_operator(&flux, &[[0.9]])?;
    assert!((found.mean[0] - mean).abs() < TOLERANCE * mean.abs(), "{found:?}, not {mean}");
    assert!((found.standard_deviation[0] - deviation).abs() < TOLERANCE * deviation, "{deviation}");
    // A functional of one point is the same thing, and so are weights that cancel.
    let sum = Functional { operator: flux, points: vec![[0.9]; 3], weights: vec![1.0, 2.0, -1.0] };
    let (twice, spread) = ensemble.predict_functional(&sum)?;
    assert!((twice - 2.0 * mean).abs() < TOLERANCE * mean.abs(), "{twice}");
    assert!((spread - 2.0 * deviation).abs() < 1e-6 * deviation, "{spread}");
    Ok(())
}

#[test]
fn without_draws_there_is_no_prediction() -> Result<(), GpError> {
    // u = 0.7667 x − x²/3 tells D = 1.5 well.
    let places = [[0.3], [0.5], [0.8], [1.0]];
    let measured = Data::new().values(&places, &[0.2, 0.3, 0.4, 0.4333], Noise::Known(0.002));
    let (_, mut ensemble, _) = spring(measured)?;
    for level in [95.0, -0.1, f64::NAN] {
        let refused = ensemble.interval("D", level).unwrap_err().to_string();
        assert!(refused.contains("between 0 and 1"), "{level}: {refused}");
    }
    assert!(ensemble.identifies("D")?);
    ensemble.draws.clear();
    let none = GpError::Invalid("the ensemble has no draws; keep at least one".into());
    assert_eq!(ensemble.predict(&[[0.5]]).unwrap_err(), none);
    assert_eq!(ensemble.interval("D", 0.95).unwrap_err(), none);
    Ok(())
}

#[test]
fn draws_about_a_fit_have_the_quantiles_of_the_posterior() -> Result<(), GpError> {
    const DRAWS: usize = 4000;
    // Eight independent values hardly larger than their errors: the one parameter is their deviation, with a long lower tail.
    let domain = Domain::interval("x", [0.0, 7.0])?;
    let independent = |_: &[Series], x: &[Series; 1], y: &[Series; 1]| {
        x[0].constant(if x[0].value() == y[0].value() { 1.0 } else { 0.0 })
    };
    let kernel = Formula::new("independent", Vec::new(), independent);
    let prior = Prior::unconstrained(&Problem::new(domain, Operator::identity())?, &kernel)?;
    let places: Vec<[f64; 1]> = (0..8).map(|k| [f64::from(k)]).collect();
    let y = [0.9, -1.4, 0.3, 1.8, -0.7, 1.1, -1.6, 0.5];
    let data = Data::new().values(&places, &y, Noise::Known(1.0));
    let fit = Model::new(prior, data, Evidence::Joint)?.fit(&FitOptions::default())?;
    let model = fit.model();
    let [parameter] = model.parameters() else { panic!("one parameter") };
    let Hyperprior::LogNormal { median, standard_deviation } = parameter.hyperprior else {
        panic!("{:?}", parameter.hyperprior)
    };
    let [lower, upper] = parameter.bounds.map(|bound| parameter.to_scale(bound));
    const CELLS: usize = 4000;
    let centre = |k: usize| lower + (upper - lower) * (k as f64 + 0.5) / CELLS as f64;
    let log_density = |k: usize| {
        let z = (centre(k) - median.ln()) / standard_deviation;
        Ok(model.log_evidence(&[centre(k)])? - 0.5 * z * z)
    };
    let logs: Vec<f64> = (0..CELLS).map(log_density).collect::<Result<_, GpError>>()?;
    let most = logs.iter().fold(f64::NEG_INFINITY, |most, log| most.max(*log));
    let density: Vec<f64> = logs.iter().map(|log| (log - most).exp()).collect();
    let whole: f64 = density.iter().sum();

    let ensemble = laplace(&fit, DRAWS, 1)?;
    assert!(ensemble.k_hat.is_some_and(|k_hat| k_hat < 0.4), "{:?}", ensemble.k_hat);
    assert_eq!(ensemble.draws.len(), DRAWS);
    let mut below = 0.0;
    let mut shares = [0.025, 0.16, 0.5, 0.84, 0.975].into_iter().peekable();
    for (k, density) in density.iter().enumerate() {
        below += density / whole;
        let Some(share) = shares.next_if(|share| below >= *share) else { continue };
        let drawn = ensemble.draws.iter().filter(|draw| draw[0] < centre(k)).count();
        let drawn = drawn as f64 / DRAWS as f64;
        // Five standard deviations of a share of independent draws.
        let bar = 5.0 * (share * (1.0 - share) / DRAWS as f64).sqrt();
        assert!((drawn - share).abs() < bar, "{share}: {drawn}");
    }
    assert_eq!(shares.next(), None, "all quantiles were met");
    Ok(())
}
