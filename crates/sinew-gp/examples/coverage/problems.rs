//! Inverse problems with known solutions, none of them the thesis'.

use sinew_gp::{
    Condition, Data, Derivative, Domain, Field, GpError, Operator, Parameter, Periodicity, Problem,
    Series, Side, constant, field,
};
use std::f64::consts::PI;

/// A problem, its solution at the true parameters, and what is measured.
pub(crate) struct Case<const D: usize> {
    pub name: &'static str,
    pub problem: Problem<D>,
    pub solution: Field<D>,
    /// Names and true values.
    pub truth: Vec<(&'static str, f64)>,
    /// Values and collocation points.
    pub counts: [usize; 2],
    /// Adds what is given besides the equation.
    pub given: fn(&Self, Data<D>) -> Result<Data<D>, GpError>,
}

/// Equation alone.
pub(crate) fn nothing<const D: usize>(_: &Case<D>, data: Data<D>) -> Result<Data<D>, GpError> {
    Ok(data)
}

impl<const D: usize> Case<D> {
    /// The right-hand side at a point, from the solution's derivatives.
    pub(crate) fn load(&self, x: [f64; D]) -> f64 {
        let operator: &Operator<D> = self.problem.equation();
        let degrees = std::array::from_fn(|d| {
            operator.terms().iter().map(|term| term.derivative.orders[d]).max().unwrap_or(0)
        });
        let series = self.solution.at(Series::variables(x, degrees));
        let value = |name: &str| {
            self.truth.iter().find(|(known, _)| *known == name).expect("a true value").1
        };
        let of = |term: &sinew_gp::Term<D>| {
            let powers = term.parameters.iter().map(|(p, n)| value(p.name()).powi(*n));
            let factor = term.function.as_ref().map_or(1.0, |function| function.value(x));
            term.scale
                * powers.product::<f64>()
                * factor
                * series.derivative(&term.derivative.orders)
        };
        let source = |term: &sinew_gp::Term<D>| {
            let powers = term.parameters.iter().map(|(p, n)| value(p.name()).powi(*n));
            let factor = term.function.as_ref().map_or(1.0, |function| function.value(x));
            term.scale * powers.product::<f64>() * factor
        };
        let sources = operator.sources().iter().map(source);
        let load: f64 = operator.terms().iter().map(of).chain(sources).sum();
        let size = operator.terms().iter().map(|term| of(term).abs()).sum::<f64>();
        // What cancels but for rounding is zero.
        if load.abs() < 1e-12 * size { 0.0 } else { load }
    }
}

/// u = 0.
pub(crate) fn zero<const D: usize>() -> Condition<D> {
    Condition::Dirichlet(constant(0.0))
}

/// No flux.
pub(crate) fn flat<const D: usize>() -> Condition<D> {
    Condition::Neumann(constant(0.0))
}

/// The unit square of x and t.
pub(crate) fn plane() -> Result<Domain<2>, GpError> {
    Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])
}

/// A function of x and t at t = 0.
pub(crate) fn at_first(solution: &Field<2>) -> Field<2> {
    let solution = solution.clone();
    field(move |[x, t]: [Series; 2]| {
        let none = t.constant(0.0);
        solution.at([x, none])
    })
}

/// Problem with 25 values and 25 points.
pub(crate) fn two(
    name: &'static str,
    problem: Problem<2>,
    solution: Field<2>,
    truth: Vec<(&'static str, f64)>,
) -> Case<2> {
    Case { name, problem, solution, truth, counts: [25, 25], given: nothing }
}

/// A solute leaves a slab: one face sealed, one washed.
pub(crate) fn slab() -> Result<Case<2>, GpError> {
    const D: f64 = 0.3;
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let solution =
        field(|[x, t]: [Series; 2]| (x * (PI / 2.0)).cos() * (t * (-D * PI * PI / 4.0)).exp());
    let problem = Problem::new(domain, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, flat())?
        .condition("x", Side::Upper, zero())?
        .condition("t", Side::Lower, Condition::Dirichlet(at_first(&solution)))?;
    Ok(two("slab", problem, solution, vec![("D", D)]))
}

/// A bar that cools through its end: Robin.
pub(crate) fn cooling() -> Result<Case<2>, GpError> {
    const D: f64 = 0.5;
    /// λ tan λ = 1
    const WAVE: f64 = 0.860_333_589_019_379_7;
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let solution = field(|[x, t]: [Series; 2]| (x * WAVE).cos() * (t * (-D * WAVE * WAVE)).exp());
    let robin = Condition::Robin {
        value_factor: constant(1.0),
        slope_factor: constant(1.0),
        data: constant(0.0),
    };
    let problem = Problem::new(domain, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, flat())?
        .condition("x", Side::Upper, robin)?
        .condition("t", Side::Lower, Condition::Dirichlet(at_first(&solution)))?;
    Ok(two("cooling", problem, solution, vec![("D", D)]))
}

/// A dye carried around a ring.
pub(crate) fn ring() -> Result<Case<2>, GpError> {
    const C: f64 = 0.5;
    const D: f64 = 0.02;
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let speed = Parameter::new("c", [0.01, 5.0])?;
    let diffusivity = Parameter::new("D", [0.001, 1.0])?;
    let solution = field(|[x, t]: [Series; 2]| {
        ((x - &t * C) * (2.0 * PI)).sin() * (t * (-4.0 * PI * PI * D)).exp()
    });
    let problem = Problem::new(domain, dt + &speed * dx - &diffusivity * dx * dx)?
        .periodic("x", Periodicity::ValueAndSlope)?
        .condition("t", Side::Lower, Condition::Dirichlet(at_first(&solution)))?;
    // With 25 points half of the width of intervals is what the points leave open.
    Ok(Case { counts: [25, 60], ..two("ring", problem, solution, vec![("c", C), ("D", D)]) })
}

/// A string held back by springs: two waves that run at different speeds.
pub(crate) fn sprung_string() -> Result<Case<2>, GpError> {
    const C: f64 = 0.6;
    const M: f64 = 6.0;
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let speed = Parameter::new("c", [0.05, 5.0])?;
    let springs = Parameter::new("m", [0.1, 100.0])?;
    let solution = field(|[x, t]: [Series; 2]| {
        let wave = |n: f64| {
            let omega = (C * C * n * n * PI * PI + M).sqrt();
            (&x * (n * PI)).sin() * (&t * omega).cos()
        };
        wave(1.0) + wave(2.0) * 0.5
    });
    let start = Condition::initial(at_first(&solution), constant(0.0));
    let equation = dt * dt - &speed * (&speed * dx * dx) + &springs * Derivative::identity();
    let problem = Problem::new(domain, equation)?
        .condition("x", Side::Lower, zero())?
        .condition("x", Side::Upper, zero())?
        .condition("t", Side::Lower, start)?;
    Ok(two("sprung string", problem, solution, vec![("c", C), ("m", M)]))
}

/// Dispersion along a ring: third order.
pub(crate) fn dispersion() -> Result<Case<2>, GpError> {
    const S: f64 = 0.002;
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let strength = Parameter::new("s", [2e-5, 0.1])?;
    let solution =
        field(|[x, t]: [Series; 2]| (x * (2.0 * PI) + t * (8.0 * PI * PI * PI * S)).sin());
    let problem = Problem::new(domain, dt + &strength * dx * dx * dx)?
        .periodic("x", Periodicity::ValueAndSlope)?
        .condition("t", Side::Lower, Condition::Dirichlet(at_first(&solution)))?;
    Ok(two("dispersion", problem, solution, vec![("s", S)]))
}

/// A plate that cools: two dimensions and time.
pub(crate) fn plate() -> Result<Case<3>, GpError> {
    const D: f64 = 0.05;
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 1.0]), ("t", [0.0, 1.0])])?;
    let [dx, dy, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.002, 2.0])?;
    let solution = field(|[x, y, t]: [Series; 3]| {
        (x * PI).sin() * (y * PI).sin() * (t * (-2.0 * PI * PI * D)).exp()
    });
    let start = field(|[x, y, _]: [Series; 3]| (x * PI).sin() * (y * PI).sin());
    let problem = Problem::new(domain, dt - &diffusivity * dx * dx - &diffusivity * dy * dy)?
        .condition("x", Side::Lower, zero())?
        .condition("x", Side::Upper, zero())?
        .condition("y", Side::Lower, zero())?
        .condition("y", Side::Upper, zero())?
        .condition("t", Side::Lower, Condition::Dirichlet(start))?;
    Ok(Case {
        name: "plate",
        problem,
        solution,
        truth: vec![("D", D)],
        counts: [30, 60],
        given: nothing,
    })
}

/// A clamped beam on an elastic bed: fourth order, under a load.
pub(crate) fn beam() -> Result<Case<1>, GpError> {
    let domain = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = domain.derivatives();
    let stiffness = Parameter::new("EI", [0.05, 20.0])?;
    let bedding = Parameter::new("k", [5.0, 5000.0])?;
    let solution = field(|[x]: [Series; 1]| {
        x.squared() * (1.0 - &x).squared() * (1.0 + (&x * 5.0).sin() * 0.5) * 10.0
    });
    let equation = &stiffness * dx * dx * dx * dx + &bedding * Derivative::identity();
    let problem = Problem::new(domain, equation)?
        .condition("x", Side::Lower, Condition::clamped())?
        .condition("x", Side::Upper, Condition::clamped())?;
    let truth = vec![("EI", 1.0), ("k", 300.0)];
    Ok(Case { name: "beam", problem, solution, truth, counts: [25, 25], given: nothing })
}

/// A rod whose conductivity rises along it, heated from within.
pub(crate) fn graded_rod() -> Result<Case<1>, GpError> {
    let domain = Domain::interval("x", [0.0, 1.0])?;
    let [dx] = domain.derivatives();
    let (a, b) = (Parameter::new("a", [0.05, 20.0])?, Parameter::new("b", [0.05, 40.0])?);
    let along = field(|[x]: [Series; 1]| x);
    let solution = field(|[x]: [Series; 1]| (&x * PI).sin() + (&x * 0.3));
    let equation = -(&a * dx * dx) - &b * (along * (dx * dx)) - &b * dx;
    let end = Condition::Neumann(constant(0.3 - PI));
    let problem = Problem::new(domain, equation)?.condition("x", Side::Lower, zero())?.condition(
        "x",
        Side::Upper,
        end,
    )?;
    let truth = vec![("a", 1.0), ("b", 2.0)];
    Ok(Case { name: "graded rod", problem, solution, truth, counts: [25, 25], given: nothing })
}

/// Diffusion and reaction on a square with mixed conditions.
pub(crate) fn reaction() -> Result<Case<2>, GpError> {
    let domain = Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 1.0])])?;
    let [dx, dy] = domain.derivatives();
    let (d, k) = (Parameter::new("D", [0.02, 20.0])?, Parameter::new("k", [0.1, 100.0])?);
    let solution =
        field(|[x, y]: [Series; 2]| &x * (&x * -1.0).exp() * (y * (PI / 2.0)).cos() * 3.0);
    let robin = Condition::Robin {
        value_factor: constant(1.0),
        slope_factor: constant(1.0),
        data: field(|[_, y]: [Series; 2]| (y * (PI / 2.0)).cos() * (3.0 * (-1.0_f64).exp())),
    };
    let equation = -(&d * dx * dx) - &d * dy * dy + &k * Derivative::identity();
    let problem = Problem::new(domain, equation)?
        .condition("x", Side::Lower, zero())?
        .condition("x", Side::Upper, robin)?
        .condition("y", Side::Lower, flat())?
        .condition("y", Side::Upper, zero())?;
    Ok(two("reaction", problem, solution, vec![("D", 0.5), ("k", 3.0)]))
}

/// A membrane over a triangle.
pub(crate) fn triangle() -> Result<Case<2>, GpError> {
    let domain = Domain::polygon(["x", "y"], &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])?;
    let [dx, dy] = domain.derivatives();
    let tension = Parameter::new("T", [0.02, 20.0])?;
    let solution = field(|[x, y]: [Series; 2]| &x * &y * (1.0 - &x - &y) * x.exp() * 27.0);
    let problem = Problem::new(domain, -(&tension * dx * dx) - &tension * dy * dy)?
        .boundary(constant(0.0))?;
    Ok(two("triangle", problem, solution, vec![("T", 0.7)]))
}

/// An insulated wall with a source that comes and goes.
pub(crate) fn insulated() -> Result<Case<2>, GpError> {
    let domain = plane()?;
    let [dx, dt] = domain.derivatives();
    let diffusivity = Parameter::new("D", [0.01, 10.0])?;
    let solution = field(|[x, t]: [Series; 2]| {
        (&x * PI).cos() * (&t * -1.0).exp() + (&x * (2.0 * PI)).cos() * (&t * 3.0).sin() * 0.4
    });
    let problem = Problem::new(domain, dt - &diffusivity * dx * dx)?
        .condition("x", Side::Lower, flat())?
        .condition("x", Side::Upper, flat())?
        .condition("t", Side::Lower, Condition::Dirichlet(at_first(&solution)))?;
    Ok(two("insulated", problem, solution, vec![("D", 0.3)]))
}
