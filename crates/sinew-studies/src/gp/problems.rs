//! The boundary value problems of §4.8 with their solutions, misprints corrected.

use crate::gp::row::Truth;
use sinew_gp::{
    Condition, Derivative, Domain, GpError, Parameter, Periodicity, Problem, Series, Side,
    constant, field,
};
use std::f64::consts::PI;
use std::sync::Arc;

/// A function of the coordinates.
pub(crate) type Function<const D: usize> = Arc<dyn Fn([f64; D]) -> f64 + Send + Sync>;

/// A problem, its solution, and what is to be inferred.
#[derive(Clone)]
pub(crate) struct Setting<const D: usize> {
    /// Name in the thesis.
    pub name: &'static str,
    /// Domain, equation and conditions.
    pub problem: Problem<D>,
    /// The solution u.
    pub solution: Function<D>,
    /// The right-hand side f.
    pub load: Function<D>,
    /// Parameters of the equation with their true values.
    pub truth: Vec<Truth>,
}

impl<const D: usize> Setting<D> {
    /// A problem whose right-hand side is zero, with its parameters and its solution.
    pub(crate) fn new(
        name: &'static str,
        problem: Problem<D>,
        truth: &[(&str, f64)],
        solution: impl Fn([f64; D]) -> f64 + Send + Sync + 'static,
    ) -> Self {
        let named = |&(name, value): &(&str, f64)| Truth { name: name.into(), value };
        let truth = truth.iter().map(named).collect();
        Self { name, problem, solution: Arc::new(solution), load: Arc::new(|_| 0.0), truth }
    }

    /// Name and parameters, as the cases of the setting carry them.
    pub(crate) fn named(&self) -> (&str, &[Truth]) {
        (self.name, &self.truth)
    }
}

fn held<const D: usize>() -> Condition<D> {
    Condition::Dirichlet(constant(0.0))
}

fn insulated<const D: usize>() -> Condition<D> {
    Condition::Neumann(constant(0.0))
}

/// −u″ = f, u(0) = u′(0) = 0, u′(2) = u(2); u = x² needs f = −2, where the thesis prints 2.
pub(crate) fn poisson_1() -> Result<Setting<1>, GpError> {
    let domain = Domain::interval("x", [0.0, 2.0])?;
    let [dx] = domain.derivatives();
    let robin = Condition::Robin {
        value_factor: constant(-1.0),
        slope_factor: constant(1.0),
        data: constant(0.0),
    };
    let problem = Problem::new(domain, -(dx * dx))?
        .condition("x", Side::Lower, Condition::clamped())?
        .condition("x", Side::Upper, robin)?;
    let setting = Setting::new("Poisson-BVP-1", problem, &[], |[x]| x * x);
    Ok(Setting { load: Arc::new(|_| -2.0), ..setting })
}

/// u_t = θ u_xx on [−π/2, π/2] × [0, 1], u = sin(x) e^{−t} at the ends and at the start.
pub(crate) fn heat_1() -> Result<Setting<2>, GpError> {
    let domain = Domain::cuboid([("x", [-PI / 2.0, PI / 2.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = domain.derivatives();
    let theta = Parameter::new("theta", [0.02, 50.0])?;
    let end = |sign: f64| Condition::Dirichlet(field(move |[_, t]: [Series; 2]| (-t).exp() * sign));
    let start = Condition::Dirichlet(field(|[x, _]: [Series; 2]| x.sin()));
    let problem = Problem::new(domain, dt - &theta * dx * dx)?
        .condition("x", Side::Lower, end(-1.0))?
        .condition("x", Side::Upper, end(1.0))?
        .condition("t", Side::Lower, start)?;
    let truth = [("theta", 1.0)];
    Ok(Setting::new("Heat-BVP-1", problem, &truth, |[x, t]| x.sin() * (-t).exp()))
}

/// u_t = θ Δu on [0, π]² × [0, ½], held at the edges, u = sin x sin y at the start.
pub(crate) fn heat_2() -> Result<Setting<3>, GpError> {
    let domain = Domain::cuboid([("x", [0.0, PI]), ("y", [0.0, PI]), ("t", [0.0, 0.5])])?;
    let [dx, dy, dt] = domain.derivatives();
    let theta = Parameter::new("theta", [0.02, 50.0])?;
    let mut problem = Problem::new(domain, dt - &theta * (dx * dx) - &theta * (dy * dy))?;
    for axis in ["x", "y"] {
        for side in Side::BOTH {
            problem = problem.condition(axis, side, held())?;
        }
    }
    let start = field(|[x, y, _]: [Series; 3]| x.sin() * y.sin());
    let problem = problem.condition("t", Side::Lower, Condition::Dirichlet(start))?;
    let solution = |[x, y, t]: [f64; 3]| x.sin() * y.sin() * (-2.0 * t).exp();
    Ok(Setting::new("Heat-BVP-2", problem, &[("theta", 1.0)], solution))
}

/// u_tt = θ² u_xx on [0, π] × [0, 1], free ends, u = cos x and u_t = cos² x at the start.
pub(crate) fn wave_1() -> Result<Setting<2>, GpError> {
    let domain = Domain::cuboid([("x", [0.0, PI]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = domain.derivatives();
    let speed = Parameter::new("theta", [0.05, 20.0])?;
    let start = Condition::initial(
        field(|[x, _]: [Series; 2]| x.cos()),
        field(|[x, _]: [Series; 2]| x.cos().squared()),
    );
    let problem = Problem::new(domain, dt * dt - &speed * (&speed * dx * dx))?
        .condition("x", Side::Lower, insulated())?
        .condition("x", Side::Upper, insulated())?
        .condition("t", Side::Lower, start)?;
    let solution =
        |[x, t]: [f64; 2]| 0.5 * t + t.cos() * x.cos() + 0.25 * (2.0 * t).sin() * (2.0 * x).cos();
    Ok(Setting::new("Wave-BVP-1", problem, &[("theta", 1.0)], solution))
}

/// u_tt = θ² u_xx on [0, 1] × [½, 2½], u(0, t) = u(1, t), u = sin πx and u_t = 0 at the start.
///
/// The thesis prints u(x, 0) = sin x and u(0, t) = u(π, t), which its solution does not satisfy.
pub(crate) fn wave_2() -> Result<Setting<2>, GpError> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.5, 2.5])])?;
    let [dx, dt] = domain.derivatives();
    let speed = Parameter::new("theta", [0.05, 20.0])?;
    let start = Condition::initial(field(|[x, _]: [Series; 2]| (x * PI).sin()), constant(0.0));
    let problem = Problem::new(domain, dt * dt - &speed * (&speed * dx * dx))?
        .periodic("x", Periodicity::Value)?
        .condition("t", Side::Lower, start)?;
    let solution = |[x, t]: [f64; 2]| (PI * x).sin() * ((t - 0.5) * PI).cos();
    Ok(Setting::new("Wave-BVP-2", problem, &[("theta", 1.0)], solution))
}

/// u_t + θ₁ u_x = θ₂ u_xx on the unit square, held at both ends, u = sin(2πx) eˣ at the start.
pub(crate) fn advection_diffusion() -> Result<Setting<2>, GpError> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = domain.derivatives();
    let advection = Parameter::new("advection", [0.001, 2.0])?;
    let diffusion = Parameter::new("diffusion", [0.001, 1.0])?;
    let start = field(|[x, _]: [Series; 2]| (&x * (2.0 * PI)).sin() * x.exp());
    let problem = Problem::new(domain, dt + &advection * dx - &diffusion * (dx * dx))?
        .condition("x", Side::Lower, held())?
        .condition("x", Side::Upper, held())?
        .condition("t", Side::Lower, Condition::Dirichlet(start))?;
    let solution =
        |[x, t]: [f64; 2]| (2.0 * PI * x).sin() * (-(0.1 * PI * PI + 0.025) * t + x).exp();
    let truth = [("advection", 0.05), ("diffusion", 0.025)];
    Ok(Setting::new("Advection-diffusion", problem, &truth, solution))
}

/// −Δu + 9u = f on the unit square, free at the lower ends, held at the upper ones; the solution has
/// e^{−y} + y − 1 − e^{−1} where the thesis prints other signs.
pub(crate) fn helmholtz() -> Result<Setting<2>, GpError> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 1.0])])?;
    let [dx, dy] = domain.derivatives();
    let mut problem = Problem::new(domain, -(dx * dx) - dy * dy + 9.0 * Derivative::identity())?;
    for axis in ["x", "y"] {
        problem = problem.condition(axis, Side::Lower, insulated())?;
        problem = problem.condition(axis, Side::Upper, held())?;
    }
    let bend = |y: f64| (-y).exp() + y - 1.0 - (-1.0_f64).exp();
    let wave = |x: f64| (PI * x / 2.0).cos();
    let solution = move |[x, y]: [f64; 2]| (1.0 - x * x) * (1.0 - y * y) + wave(x) * bend(y);
    let load = move |[x, y]: [f64; 2]| {
        2.0 * (1.0 - x * x)
            + 2.0 * (1.0 - y * y)
            + wave(x) * (PI * PI / 4.0 * bend(y) - (-y).exp())
            + 9.0 * solution([x, y])
    };
    let setting = Setting::new("Helmholtz", problem, &[], solution);
    Ok(Setting { load: Arc::new(load), ..setting })
}
