//! One problem for each kind of condition beyond values, slopes, springs and joined ends.

use super::problems::{Case, at_first, flat, nothing, plane, two, zero};
use sinew_gp::{
    Condition, Data, Derivative, Domain, Field, Functional, GpError, Noise, Parameter, Problem,
    Series, Side, constant, field,
};
use std::f64::consts::PI;

/// One half of a wall that dries to both sides.
pub(crate) fn half_wall() -> Result<Case<2>, GpError> {
    const D: f64 = 0.2;
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let solution = field(|[x, t]: [Series; 2]| {
        let wave =
            |n: f64| (&x * (n * PI / 2.0)).cos() * (&t * (-D * (n * PI / 2.0).powi(2))).exp();
        wave(1.0) + wave(3.0) * 0.2
    });
    let problem = Problem::new(domain, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, Condition::symmetry())?
        .condition("x", Side::Upper, zero())?
        .condition("t", Side::Lower, Condition::Dirichlet(at_first(&solution)))?;
    Ok(Case { counts: [25, 50], ..two("half wall", problem, solution, vec![("D", D)]) })
}

/// A gangway hinged on the quay, its other end on the water: u″ = x (1 − x)².
pub(crate) fn gangway() -> Result<Case<1>, GpError> {
    let domain = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = domain.derivatives();
    let stiffness = Parameter::new("EI", [0.05, 20.0])?;
    let water = Parameter::new("k", [1.0, 400.0])?;
    let solution =
        field(|[x]: [Series; 1]| x.powi(3) / 6.0 - x.powi(4) / 6.0 + x.powi(5) / 20.0 + &x * 0.05);
    let equation = &stiffness * dx * dx * dx * dx + &water * Derivative::identity();
    let problem = Problem::new(domain, equation)?
        .condition("x", Side::Lower, Condition::simply_supported())?
        .condition("x", Side::Upper, Condition::free_end())?;
    let truth = vec![("EI", 1.0), ("k", 20.0)];
    Ok(Case { name: "gangway", problem, solution, truth, counts: [25, 25], given: nothing })
}

/// Heat through a window that is thinner above: a Robin condition with a factor that varies.
pub(crate) fn window() -> Result<Case<2>, GpError> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 1.0])])?;
    let [dx, dy] = domain.derivatives();
    let conductivity = Parameter::new("D", [0.02, 20.0])?;
    let solution = field(|[x, y]: [Series; 2]| (x * 1.2 + 0.3).sin() * y.cos());
    let film = Condition::Robin {
        value_factor: field(|[_, y]: [Series; 2]| y.squared() + 1.0),
        slope_factor: constant(1.0),
        data: field(|[_, y]: [Series; 2]| {
            ((y.squared() + 1.0) * 1.5_f64.sin() + 1.2 * 1.5_f64.cos()) * y.cos()
        }),
    };
    let u = || Condition::Dirichlet(field(|[x, y]: [Series; 2]| (x * 1.2 + 0.3).sin() * y.cos()));
    let equation = -(&conductivity * dx * dx) - &conductivity * dy * dy + Derivative::identity();
    let problem = Problem::new(domain, equation)?
        .condition("x", Side::Lower, u())?
        .condition("x", Side::Upper, film)?
        .condition("y", Side::Lower, flat())?
        .condition("y", Side::Upper, u())?;
    Ok(two("window", problem, solution, vec![("D", 0.5)]))
}

const FILM: f64 = 1.5;

/// A wall behind a film of unknown conductance: u_x + h (u − T(t)) = 0 imposed at points of its face.
pub(crate) fn film() -> Result<Case<2>, GpError> {
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.02, 20.0])?;
    let solution = field(|[x, t]: [Series; 2]| 1.0 - t.sin() * (x.squared() * 0.3 + 0.5));
    let problem = Problem::new(domain, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, flat())?
        .condition("t", Side::Lower, Condition::Dirichlet(constant(1.0)))?;
    let given = |case: &Case<2>, data: Data<2>| {
        let domain = case.problem.domain();
        let [dx, _] = domain.derivatives();
        let conductance = Parameter::new("h", [0.05, 50.0])?;
        let air: Field<2> = field(|[_, t]: [Series; 2]| 1.0 - t.sin() * (0.8 + 0.6 / FILM));
        let leaving = dx + &conductance * Derivative::identity() - &conductance * air;
        let face: Vec<[f64; 2]> = (0..10).map(|k| [1.0, 0.05 + 0.1 * f64::from(k)]).collect();
        Ok(data.imposed(leaving, &face, &[0.0; 10], Noise::Exact))
    };
    let truth = vec![("D", 0.4), ("h", FILM)];
    Ok(Case { given, ..two("film", problem, solution, truth) })
}

/// A lamp of unknown strength over a bar.
pub(crate) fn lamp() -> Result<Case<2>, GpError> {
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.02, 20.0])?;
    let strength = Parameter::new("s", [0.05, 50.0])?;
    let solution = field(|[x, t]: [Series; 2]| {
        (&x * PI).sin() * (1.0 - (-&t * 2.0).exp()) + (&x * (2.0 * PI)).sin() * t * 0.3
    });
    let light: Field<2> = field(|[x, _]: [Series; 2]| ((x - 0.5).squared() * -10.0).exp());
    let problem = Problem::new(domain, dt - &diffusivity * dx * dx - &strength * light)?
        .condition("x", Side::Lower, zero())?
        .condition("x", Side::Upper, zero())?
        .condition("t", Side::Lower, zero())?;
    Ok(two("lamp", problem, solution, vec![("D", 0.2), ("s", 2.0)]))
}

/// A closed tube of which the total amount of solute is known.
pub(crate) fn tube() -> Result<Case<1>, GpError> {
    let domain = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.02, 20.0])?;
    let solution = field(|[x]: [Series; 1]| (&x * PI).cos() + (&x * (2.0 * PI)).cos() * 0.3);
    let sealed = || Condition::Neumann(constant(0.0));
    let problem = Problem::new(domain, -(&diffusivity * dx * dx))?
        .condition("x", Side::Lower, sealed())?
        .condition("x", Side::Upper, sealed())?;
    let given = |case: &Case<1>, data: Data<1>| {
        let total = Functional::integral(case.problem.domain(), Derivative::identity(), 8)?;
        data.imposed_integral(&total, 0.0, Noise::Exact)
    };
    let truth = vec![("D", 0.7)];
    Ok(Case { name: "tube", problem, solution, truth, counts: [25, 25], given })
}
