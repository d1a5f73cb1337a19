//! Problems on which intervals were too narrow once: an initial layer, a spike at the mode, a side where values say little.

use super::problems::{Case, at_first, flat, plane, two, zero};
use sinew_gp::{Condition, Derivative, Domain, GpError, Parameter, Problem, Series, Side, field};
use std::f64::consts::PI;

/// Heat from one insulated end to one that is held, with a mode at the start that decays in a fiftieth of the time.
pub(crate) fn layer() -> Result<Case<2>, GpError> {
    const D: f64 = 0.3;
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let solution = field(|[x, t]: [Series; 2]| {
        let mode = |n: f64| {
            let wave = n * PI / 2.0;
            (&x * wave).sin() * (&t * (-D * wave * wave)).exp()
        };
        mode(1.0) + mode(5.0) * 0.5
    });
    let problem = Problem::new(domain, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, zero())?
        .condition("x", Side::Upper, flat())?
        .condition("t", Side::Lower, Condition::Dirichlet(at_first(&solution)))?;
    Ok(Case { counts: [30, 30], ..two("initial layer", problem, solution, vec![("D", D)]) })
}

/// u_t + v u_x = D u_xx − k u + f with known f: three parameters.
pub(crate) fn three() -> Result<Case<2>, GpError> {
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let d = Parameter::new("D", [0.01, 10.0])?;
    let v = Parameter::new("v", [0.05, 20.0])?;
    let k = Parameter::new("k", [0.05, 50.0])?;
    let solution =
        field(|[x, t]: [Series; 2]| (&x * PI).sin() * (&t * -0.7).exp() + &x * (1.0 - &x) * &t);
    let equation = dt + &v * dx - &d * dx * dx + &k * Derivative::identity();
    let problem = Problem::new(domain, equation)?
        .condition("x", Side::Lower, zero())?
        .condition("x", Side::Upper, zero())?
        .condition("t", Side::Lower, Condition::Dirichlet(at_first(&solution)))?;
    let truth = vec![("D", 0.2), ("v", 1.0), ("k", 2.0)];
    Ok(Case { counts: [25, 30], ..two("advection", problem, solution, truth) })
}

/// A membrane on a bed, −Δu + k u = f, with a side that is free to move.
pub(crate) fn screened() -> Result<Case<2>, GpError> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 1.0])])?;
    let [dx, dy] = domain.derivatives();
    let bed = Parameter::new("k", [0.1, 100.0])?;
    let solution = field(|[x, y]: [Series; 2]| {
        (&x * (1.5 * PI)).sin() * (&y * PI).sin() + &x * (2.0 - &x) * &y * (1.0 - &y)
    });
    let problem = Problem::new(domain, -(dx * dx) - dy * dy + &bed * Derivative::identity())?
        .condition("x", Side::Lower, zero())?
        .condition("x", Side::Upper, flat())?
        .condition("y", Side::Lower, zero())?
        .condition("y", Side::Upper, zero())?;
    Ok(two("screened", problem, solution, vec![("k", 8.0)]))
}
