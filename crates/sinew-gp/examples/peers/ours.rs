//! Both problems with this crate.

use crate::{Answer, Given};
use sinew_gp::{
    Condition, Data, Derivative, Domain, Evidence, FitOptions, GpError, Model, Noise, Parameter,
    Prior, Problem, Side, constant, field, laplace, squared_exponential,
};
use std::f64::consts::PI;

/// Diffusivity of a slab.
pub(crate) fn slab(given: &Given<2>) -> Result<Answer, GpError> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let start = Condition::Dirichlet(field(|[x, _]| (x * (PI / 2.0)).cos()));
    let problem = Problem::new(domain, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, Condition::Neumann(constant(0.0)))?
        .condition("x", Side::Upper, Condition::Dirichlet(constant(0.0)))?
        .condition("t", Side::Lower, start)?;
    solve(&problem, given, "D")
}

/// Stiffness of a beam.
pub(crate) fn beam(given: &Given<1>) -> Result<Answer, GpError> {
    let domain = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = domain.derivatives();
    let stiffness = Parameter::new("EI", [0.05, 20.0])?;
    let equation = &stiffness * dx * dx * dx * dx + 300.0 * Derivative::identity();
    let problem = Problem::new(domain, equation)?
        .condition("x", Side::Lower, Condition::clamped())?
        .condition("x", Side::Upper, Condition::clamped())?;
    solve(&problem, given, "EI")
}

fn solve<const D: usize>(
    problem: &Problem<D>,
    given: &Given<D>,
    name: &str,
) -> Result<Answer, GpError> {
    let data = Data::new().values(&given.places, &given.values, Noise::Learned).equation(
        &given.points,
        &given.loads,
        Noise::Exact,
    );
    let prior = Prior::constrained(problem, &squared_exponential())?;
    let fit = Model::new(prior, data, Evidence::Auto)?.fit(&FitOptions::default())?;
    let interval = laplace(&fit, 300, 1)?.interval(name, 0.95)?;
    let mean = fit.conditional()?.mean(&given.grid)?;
    Ok(Answer { estimate: fit.parameter(name)?, interval, mean })
}
