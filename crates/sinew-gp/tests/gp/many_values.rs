//! Means over cells against all of their values.

use sinew_gp::{
    Condition, Conditional, Data, Domain, Evidence, FitOptions, Formula, GpError, Model, Noise,
    Operator, Parameter, Prior, Problem, Series, Side, constant, field, squared_exponential,
};
use std::f64::consts::PI;
use std::sync::Arc;

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
    let (problem, data) = slab(300)?;
    let fit = |data: Data<2>| {
        let prior = Prior::constrained(&problem, &squared_exponential())?;
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
fn means_of_quadratics_are_those_of_the_values() -> Result<(), GpError> {
    let domain = Domain::cuboid([("x", [0.0, 2.0]), ("y", [0.0, 1.0])])?;
    let places = domain.sample(2000, 3)?;
    let u = |[x, y]: [f64; 2]| 1.0 + x - 2.0 * y + 0.5 * x * x - x * y + 3.0 * y * y;
    let values: Vec<f64> = places.iter().map(|x| u(*x)).collect();
    let data = Data::new().values(&places, &values, Noise::Learned).averaged(40);
    assert_eq!(data.count(), 40);
    // Few values stay as they are.
    let few = Data::new().values(&places[..50], &values[..50], Noise::Learned).averaged(40);
    assert_eq!(few.count(), 50);

    // Value, slope and curvature where x = 0 make u the prior mean, which means over cells of u leave where it is.
    let given = Condition::Derivatives(vec![
        (0, field(|[_, y]: [Series; 2]| y.squared() * 3.0 - &y * 2.0 + 1.0)),
        (1, field(|[_, y]: [Series; 2]| y - 1.0)),
        (2, constant(1.0)),
    ]);
    let free = Problem::new(domain.clone(), Operator::identity())?;
    let held = free.clone().condition("x", Side::Lower, given)?;
    let prior = Prior::constrained(&held, &squared_exponential())?;
    let model = Arc::new(Model::new(prior, data.clone(), Evidence::Joint)?);
    let at: Vec<f64> = model
        .parameters()
        .iter()
        .map(|p| match p.name.as_str() {
            "amplitude 1" => 10.0_f64.ln(),
            "noise 1" => 0.0,
            _ => 0.5_f64.ln(),
        })
        .collect();
    let grid = domain.grid(9);
    let mean = Conditional::new(model, &at)?.mean(&grid)?;
    for (mean, x) in mean.iter().zip(&grid) {
        assert!((mean - u(*x)).abs() < 1e-12, "{x:?}: {mean} {}", u(*x));
    }

    // A constant with a variance of one and errors of ten is known as from 2000 values.
    let one = |_: &[Series], x: &[Series; 2], _: &[Series; 2]| x[0].constant(1.0);
    let prior = Prior::unconstrained(&free, &Formula::new("constant", Vec::new(), one))?;
    let model = Arc::new(Model::new(prior, data, Evidence::Joint)?);
    let conditional = Conditional::new(model.clone(), &[0.0, 10.0_f64.ln()])?;
    let deviation = conditional.predict(&[[0.5, 0.5]])?.standard_deviation[0];
    // Jitter is a part of 5e-11 of the errors of means.
    assert!((deviation * 21.0_f64.sqrt() - 1.0).abs() < 1e-9, "{deviation}");
    // Of errors far larger than the values each mean has one degree of freedom, and the others are left to the scatter about
    // linear functions with three numbers in each cell: 2000 − 120.
    let slope = model.evaluate(&[1e-6_f64.ln(), 1e6_f64.ln()])?.gradient[1];
    assert!((slope + 40.0 + (2000.0 - 120.0)).abs() < 1e-6, "{slope}");
    Ok(())
}
