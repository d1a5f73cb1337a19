//! The boundary value problems of §4.8 with their solutions, misprints corrected.

use crate::gp::row::Truth;
use sinew_gp::{
    Condition, Derivative, Domain, GpError, Parameter, Periodicity, Problem, Series, Side,
    constant, field,
};
use std::f64::consts::{PI, SQRT_2};
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
    /// Name and parameters, as the cases of the setting carry them.
    pub(crate) fn named(&self) -> (&str, &[Truth]) {
        (self.name, &self.truth)
    }
}

fn truth(values: &[(&str, f64)]) -> Vec<Truth> {
    values.iter().map(|(name, value)| Truth { name: (*name).into(), value: *value }).collect()
}

fn zero<const D: usize>() -> Function<D> {
    Arc::new(|_| 0.0)
}

fn held<const D: usize>() -> Condition<D> {
    Condition::Dirichlet(constant(0.0))
}

fn insulated<const D: usize>() -> Condition<D> {
    Condition::Neumann(constant(0.0))
}

/// −u″ = f, u(0) = u′(0) = 0, u′(2) = u(2); u = x² needs f = −2, where the thesis prints 2.
///
/// # Errors
/// None that the constants here can cause; those of the library are passed on.
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
    Ok(Setting {
        name: "Poisson-BVP-1",
        problem,
        solution: Arc::new(|[x]| x * x),
        load: Arc::new(|_| -2.0),
        truth: Vec::new(),
    })
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
    Ok(Setting {
        name: "Heat-BVP-1",
        problem,
        solution: Arc::new(|[x, t]| x.sin() * (-t).exp()),
        load: zero(),
        truth: truth(&[("theta", 1.0)]),
    })
}

/// u_t = D u_xx on the unit square, held at x = 0 and insulated at 1, with a mode at the start that decays in a fiftieth of the
/// time; not the thesis'.
pub(crate) fn layer() -> Result<Setting<2>, GpError> {
    const D: f64 = 0.3;
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let start =
        field(|[x, _]: [Series; 2]| (&x * (PI / 2.0)).sin() + (&x * (2.5 * PI)).sin() * 0.5);
    let problem = Problem::new(domain, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, held())?
        .condition("x", Side::Upper, insulated())?
        .condition("t", Side::Lower, Condition::Dirichlet(start))?;
    let mode = |n: f64, [x, t]: [f64; 2]| {
        let wave = n * PI / 2.0;
        (wave * x).sin() * (-D * wave * wave * t).exp()
    };
    Ok(Setting {
        name: "Initial layer",
        problem,
        solution: Arc::new(move |x| mode(1.0, x) + 0.5 * mode(5.0, x)),
        load: zero(),
        truth: truth(&[("D", D)]),
    })
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
    Ok(Setting {
        name: "Heat-BVP-2",
        problem: problem.condition("t", Side::Lower, Condition::Dirichlet(start))?,
        solution: Arc::new(|[x, y, t]| x.sin() * y.sin() * (-2.0 * t).exp()),
        load: zero(),
        truth: truth(&[("theta", 1.0)]),
    })
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
    Ok(Setting {
        name: "Wave-BVP-1",
        problem,
        solution: Arc::new(|[x, t]| {
            0.5 * t + t.cos() * x.cos() + 0.25 * (2.0 * t).sin() * (2.0 * x).cos()
        }),
        load: zero(),
        truth: truth(&[("theta", 1.0)]),
    })
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
    Ok(Setting {
        name: "Wave-BVP-2",
        problem,
        solution: Arc::new(|[x, t]| (PI * x).sin() * ((t - 0.5) * PI).cos()),
        load: zero(),
        truth: truth(&[("theta", 1.0)]),
    })
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
    Ok(Setting {
        name: "Advection-diffusion",
        problem,
        solution: Arc::new(|[x, t]| {
            (2.0 * PI * x).sin() * (-(0.1 * PI * PI + 0.025) * t + x).exp()
        }),
        load: zero(),
        truth: truth(&[("advection", 0.05), ("diffusion", 0.025)]),
    })
}

/// −Δu + 9u = f on the unit square, free at the lower ends, held at the upper ones; the solution has
/// e^{−y} + y − 1 − e^{−1} where the thesis prints other signs.
pub(crate) fn helmholtz() -> Result<Setting<2>, GpError> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 1.0])])?;
    let [dx, dy] = domain.derivatives();
    let mut problem = Problem::new(domain, -(dx * dx) - dy * dy + 9.0 * Derivative::identity())?;
    for axis in ["x", "y"] {
        problem = problem.condition(axis, Side::Lower, insulated())?.condition(
            axis,
            Side::Upper,
            held(),
        )?;
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
    Ok(Setting {
        name: "Helmholtz",
        problem,
        solution: Arc::new(solution),
        load: Arc::new(load),
        truth: Vec::new(),
    })
}

/// ε of [`allen_cahn`].
const WIDTH: f64 = 0.05;

/// The linear part u_t − ε² u_xx of Allen and Cahn's equation on [−1, 1] × [0, 1] for the front
/// ½ (1 − tanh((x − ct) / 2√2ε)) with c = 3ε/√2 = 0.106, in the coordinate s of
/// x = sinh(κs)/sinh κ, which is the finer about x = 0 the larger κ.
pub(crate) fn allen_cahn(kappa: f64, unknown: bool) -> Result<Setting<2>, GpError> {
    let domain = Domain::cuboid([("s", [-1.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [ds, dt] = domain.derivatives();
    let sinh = |x: &Series| (x.exp() - (x * -1.0).exp()) * 0.5;
    let cosh = |x: &Series| (x.exp() + (x * -1.0).exp()) * 0.5;
    // ∂²/∂x² = X′⁻² ∂²/∂s² − X″ X′⁻³ ∂/∂s with X = sinh(κs)/sinh κ.
    let slope = move |s: &Series| cosh(&(s * kappa)) * (kappa / kappa.sinh());
    let bend = move |s: &Series| sinh(&(s * kappa)) * (kappa * kappa / kappa.sinh());
    let second = field(move |[s, _]: [Series; 2]| slope(&s).squared().recip());
    let first = field(move |[s, _]: [Series; 2]| bend(&s) / slope(&s).powi(3));
    let curvature = second * (ds * ds) - first * ds;
    let diffusion = match unknown {
        true => {
            let epsilon = Parameter::new("epsilon", [0.1 * WIDTH, 10.0 * WIDTH])?;
            &epsilon * (&epsilon * curvature)
        }
        false => WIDTH * WIDTH * curvature,
    };
    const SPEED: f64 = 3.0 * WIDTH / SQRT_2;
    const STEEPNESS: f64 = 1.0 / (2.0 * SQRT_2 * WIDTH);
    let known = || {
        Condition::Dirichlet(field(move |[s, t]: [Series; 2]| {
            let x = sinh(&(s * kappa)) / kappa.sinh();
            (((x - t * SPEED) * STEEPNESS).tanh() - 1.0) * -0.5
        }))
    };
    let problem = Problem::new(domain, dt - diffusion)?
        .condition("s", Side::Lower, known())?
        .condition("s", Side::Upper, known())?
        .condition("t", Side::Lower, known())?;
    Ok(Setting {
        name: "Allen-Cahn",
        problem,
        solution: Arc::new(move |[s, t]| {
            let x = (kappa * s).sinh() / kappa.sinh();
            0.5 * (1.0 - ((x - SPEED * t) * STEEPNESS).tanh())
        }),
        load: zero(),
        truth: if unknown { truth(&[("epsilon", WIDTH)]) } else { Vec::new() },
    })
}
