//! Posteriors of many values through few of them, against the exact ones.

use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, GpError, Model, Noise, Parameter, Posterior,
    Prior, Problem, ReducedOptions, Side, SquaredExponential, constant, field,
};
use std::f64::consts::PI;

const D: f64 = 0.3;

/// A slab that is washed at one face, as measured at `count` places with errors of 2 %.
fn slab(count: usize) -> Result<(Problem<2>, Data<2>), GpError> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let problem = Problem::new(domain.clone(), dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, Condition::Neumann(constant(0.0)))?
        .condition("x", Side::Upper, Condition::Dirichlet(constant(0.0)))?
        .condition(
            "t",
            Side::Lower,
            Condition::Dirichlet(field(|[x, _]| (x * (PI / 2.0)).cos())),
        )?;
    let places = domain.sample(count, 1)?;
    let y: Vec<f64> =
        places.iter().enumerate().map(|(k, x)| exact(*x) + 0.03 * (7.0 * k as f64).sin()).collect();
    let at = domain.sample(40, 2)?;
    let data =
        Data::new().values(&places, &y, Noise::Learned).equation(&at, &[0.0; 40], Noise::Exact);
    Ok((problem, data))
}

fn exact([x, t]: [f64; 2]) -> f64 {
    (x * PI / 2.0).cos() * (-D * PI * PI / 4.0 * t).exp()
}

#[test]
fn few_of_the_values_tell_what_all_do() -> Result<(), GpError> {
    let (problem, data) = slab(500)?;
    let prior = || Prior::constrained(&problem, &SquaredExponential::new());
    let fit =
        Model::new(prior()?, data.thinned(100, 3), Evidence::Auto)?.fit(&FitOptions::default())?;
    let all = std::sync::Arc::new(Model::new(prior()?, data.clone(), Evidence::Auto)?);
    let whole = Posterior::new(all, &fit.outcome().parameters)?;
    let places = problem.domain().sample(60, 9)?;
    let expected = whole.predict(&places)?;
    let reduced = |most: usize| {
        let options = ReducedOptions { most, divergence: 0.01 };
        Model::new(prior()?, data.clone(), Evidence::Auto)?.reduced(&fit, &options)
    };
    // Too few are refused with their number; more come nearer.
    let mut before = f64::INFINITY;
    for most in [15, 25] {
        let Err(GpError::NotReduced { chosen, divergence, asked, .. }) = reduced(most) else {
            panic!("{most} observations do not tell 540");
        };
        println!("{chosen} of 540: divergence {divergence:.1e} for {asked}");
        assert!(chosen == most && divergence > asked && divergence <= before);
        before = divergence;
    }
    let reduced = reduced(600)?;
    let found = reduced.posterior.predict(&places)?;
    // Largest difference of means in standard deviations, and largest ratio of these.
    let (mut off, mut ratio) = (0.0_f64, 0.0_f64);
    for k in 0..places.len() {
        let sigma = expected.standard_deviation[k];
        off = off.max((found.mean[k] - expected.mean[k]).abs() / sigma);
        ratio = ratio.max((found.standard_deviation[k] / sigma).ln().abs());
    }
    println!(
        "{} of 540: divergence below {:.1e}, means off by {off:.1e}, deviations by {ratio:.1e}",
        reduced.chosen, reduced.divergence
    );
    // At one place (Δ/σ)²/2 is no more than the divergence of all, to first order.
    assert!(off * off / 2.0 <= 1.1 * reduced.divergence, "{off} {}", reduced.divergence);
    assert!(reduced.divergence < 0.015, "{}", reduced.divergence);
    Ok(())
}

#[test]
fn means_over_cells_tell_what_all_values_do() -> Result<(), GpError> {
    let (problem, data) = slab(400)?;
    let fit = |data: Data<2>| {
        let prior = Prior::constrained(&problem, &SquaredExponential::new())?;
        Model::new(prior, data, Evidence::Auto)?.fit(&FitOptions::default())
    };
    let (all, cells) = (fit(data.clone())?, fit(data.averaged(30))?);
    let [[low, high], [lower, upper]] = [all.interval("D", 0.95)?, cells.interval("D", 0.95)?];
    let sigmas = [all.parameter("noise 1")?, cells.parameter("noise 1")?];
    println!("all: {low:.4} to {high:.4}; cells: {lower:.4} to {upper:.4}; noise {sigmas:.5?}");
    let width = (upper - lower) / (high - low);
    assert!((0.7..1.5).contains(&width), "{width}");
    assert!((0.5 * (lower + upper - low - high)).abs() < 0.5 * (high - low));
    assert!((sigmas[1] / sigmas[0] - 1.0).abs() < 0.05, "{sigmas:?}");
    Ok(())
}

#[test]
fn another_models_parameters_are_refused() -> Result<(), GpError> {
    let (problem, data) = slab(60)?;
    let prior = || Prior::constrained(&problem, &SquaredExponential::new());
    let fit = Model::new(prior()?, data.clone(), Evidence::Auto)?.fit(&FitOptions::default())?;
    let free = Prior::unconstrained(&problem, &SquaredExponential::new())?;
    let refused = Model::new(free, data, Evidence::Auto)?
        .reduced(&fit, &ReducedOptions::default())
        .unwrap_err();
    assert!(refused.to_string().contains("same prior and groups"), "{refused}");
    Ok(())
}
