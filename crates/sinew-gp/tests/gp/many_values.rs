//! Means over cells against all of their values.

use sinew_gp::{
    Condition, Data, Domain, Evidence, FitOptions, GpError, Model, Noise, Parameter, Prior,
    Problem, Side, SquaredExponential, constant, field,
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
