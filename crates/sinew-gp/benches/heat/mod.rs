//! Heat-BVP-1 with built-in conditions, half of the observations of u and half of the equation.

use sinew_gp::{
    Condition, Data, Domain, Evidence, GpError, Model, Noise, Parameter, Prior, Problem, Series,
    Side, field, squared_exponential,
};
use std::f64::consts::PI;

pub(crate) fn heat(size: usize, evidence: Evidence) -> Result<Model<2>, GpError> {
    let domain = Domain::cuboid([("x", [-PI / 2.0, PI / 2.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = domain.derivatives();
    let theta = Parameter::new("theta", [0.02, 50.0])?;
    let end = |sign: f64| Condition::Dirichlet(field(move |[_, t]: [Series; 2]| (-t).exp() * sign));
    let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| x.sin()));
    let problem = Problem::new(domain.clone(), dt - &theta * dx * dx)?
        .condition("x", Side::Lower, end(-1.0))?
        .condition("x", Side::Upper, end(1.0))?
        .condition("t", Side::Lower, start)?;
    let places = domain.sample(size / 2, 1)?;
    let y: Vec<f64> = places.iter().map(|[x, t]| x.sin() * (-t).exp()).collect();
    let data = Data::new().values(&places, &y, Noise::Learned).equation(
        &domain.sample(size / 2, 2)?,
        &vec![0.0; size / 2],
        Noise::Exact,
    );
    Model::new(Prior::constrained(&problem, &squared_exponential())?, data, evidence)
}

/// Middle of the starting range of every parameter.
pub(crate) fn middle(model: &Model<2>) -> Vec<f64> {
    model.parameters().iter().map(|p| p.to_scale((p.start[0] * p.start[1]).sqrt())).collect()
}

/// Error of the derivative along the diagonal, against a difference of fourth order.
pub(crate) fn relative_error(model: &Model<2>, at: &[f64]) -> Result<f64, GpError> {
    const STEP: f64 = 1e-3;
    let value = |steps: f64| {
        let moved: Vec<f64> = at.iter().map(|x| x + steps * STEP).collect();
        model.log_evidence(&moved)
    };
    let difference =
        (8.0 * (value(1.0)? - value(-1.0)?) - (value(2.0)? - value(-2.0)?)) / (12.0 * STEP);
    let slope: f64 = model.evaluate(at)?.gradient.iter().sum();
    Ok((slope - difference).abs() / slope.abs())
}
