//! Linear differential operators, written as they are on paper, and weighted sums of their values: integrals by quadrature.

use crate::problem::domain::grid;
use crate::{Domain, Field, Result, Side};
use nalgebra::DMatrix;
use std::ops::{Add, Mul, Neg, Sub};
use std::sync::Arc;

/// Highest order of a derivative along one axis.
pub const MOST_DERIVATIVES: usize = 4;

/// A partial derivative of any order; products of derivatives are derivatives.
///
/// ```
/// use sinew_gp::{Derivative, Domain};
///
/// let [dx, dy] = Domain::cuboid([("x", [0.0, 1.0]), ("y", [0.0, 1.0])])?.derivatives();
/// assert_eq!((dx * dx * dy).orders, [2, 1]);
/// # Ok::<(), sinew_gp::GpError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Derivative<const D: usize> {
    /// Order along each axis.
    pub orders: [usize; D],
}

impl<const D: usize> Derivative<D> {
    /// No derivative at all: the function itself.
    pub fn identity() -> Self {
        Self { orders: [0; D] }
    }

    /// The first derivative along axis `axis`.
    ///
    /// # Panics
    /// If there is no such axis.
    pub fn along(axis: usize) -> Self {
        let mut orders = [0; D];
        orders[axis] = 1;
        Self { orders }
    }
}

/// A named unknown of an equation, within bounds.
///
/// With a positive lower bound it is inferred on a logarithmic scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    name: Arc<str>,
    pub(crate) bounds: [f64; 2],
}

impl Parameter {
    /// A parameter by name, with its lower and upper bound.
    ///
    /// # Errors
    /// If the bounds are not finite and ascending.
    pub fn new(name: &str, [lower, upper]: [f64; 2]) -> Result<Self> {
        ensure!(
            lower.is_finite() && upper.is_finite() && lower < upper,
            "parameter {name} has bounds [{lower}, {upper}]; give finite bounds in ascending order"
        );
        Ok(Self { name: name.into(), bounds: [lower, upper] })
    }

    /// Name of the parameter.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Halfway between its bounds, on the scale that it is inferred on.
    pub(crate) fn middle(&self) -> f64 {
        let [lower, upper] = self.bounds;
        if lower > 0.0 { (lower * upper).sqrt() } else { 0.5 * (lower + upper) }
    }
}

/// One summand of an operator: number × parameters × function × derivative.
#[derive(Clone, Debug)]
pub struct Term<const D: usize> {
    /// Number in front.
    pub scale: f64,
    /// Parameters in front, each once, with their powers.
    pub parameters: Vec<(Parameter, i32)>,
    /// Function in front, if any.
    pub function: Option<Field<D>>,
    /// The derivative that is taken.
    pub derivative: Derivative<D>,
}

impl<const D: usize> Term<D> {
    fn times(mut self, parameter: &Parameter) -> Self {
        match self.parameters.iter_mut().find(|(known, _)| known == parameter) {
            Some((_, power)) => *power += 1,
            None => self.parameters.push((parameter.clone(), 1)),
        }
        self
    }
}

/// A linear differential operator: a sum of coefficient × derivative (Definition 4.3.1), and of known functions with numbers and
/// parameters in front, as a load of unknown strength, which are part of the left-hand side.
///
/// Numbers, [`Parameter`]s and [`Field`]s multiply derivatives from the left.
///
/// ```
/// use sinew_gp::{Domain, Operator, Parameter, field};
///
/// let [dx, dt] = Domain::cuboid([("x", [0.0, 1.0]), ("t", [0.0, 1.0])])?.derivatives();
/// let speed = Parameter::new("speed", [0.1, 10.0])?;
/// let wave = dt * dt - &speed * (&speed * dx * dx);
/// assert_eq!(wave.terms().len(), 2);
/// let graded = dt - field(|[x, _]| x * 2.0 + 1.0) * dx * dx;
/// assert_eq!(graded.order(), 2);
///
/// // A lamp of unknown strength over the middle: u_t − u_xx = s exp(−x²).
/// let strength = Parameter::new("strength", [0.1, 10.0])?;
/// let heated = dt - dx * dx - &strength * field(|[x, _]| (-x.squared()).exp());
/// assert_eq!(heated.sources().len(), 1);
/// # Ok::<(), sinew_gp::GpError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Operator<const D: usize> {
    terms: Vec<Term<D>>,
    /// Terms as factors of 1, with the function always there.
    sources: Vec<Term<D>>,
}

impl<const D: usize> Operator<D> {
    /// The function itself.
    pub fn identity() -> Self {
        Derivative::identity().into()
    }

    /// Summands of the operator.
    pub fn terms(&self) -> &[Term<D>] {
        &self.terms
    }

    /// Highest total order of a derivative in it.
    pub fn order(&self) -> usize {
        self.terms.iter().map(|t| t.derivative.orders.iter().sum()).max().unwrap_or(0)
    }

    /// Highest order along each axis.
    pub fn orders(&self) -> [usize; D] {
        let most = |d| self.terms.iter().map(|t| t.derivative.orders[d]).max().unwrap_or(0);
        std::array::from_fn(most)
    }

    /// Known functions of the operator: summands without u, each with the identity as its derivative.
    pub fn sources(&self) -> &[Term<D>] {
        &self.sources
    }

    /// Refuses derivatives of too high an order.
    pub(crate) fn check_orders(&self, domain: &Domain<D>) -> Result<()> {
        for (order, axis) in self.orders().into_iter().zip(domain.names()) {
            ensure!(
                order <= MOST_DERIVATIVES,
                "derivative of order {order} along {axis}; at most {MOST_DERIVATIVES} is supported; write the equation as one of lower order"
            );
        }
        Ok(())
    }

    /// One summand alone.
    pub(crate) fn of(term: &Term<D>) -> Self {
        Self { terms: vec![term.clone()], sources: Vec::new() }
    }

    fn map(self, change: impl Fn(Term<D>) -> Term<D>) -> Self {
        Self {
            terms: self.terms.into_iter().map(&change).collect(),
            sources: self.sources.into_iter().map(&change).collect(),
        }
    }
}

impl<const D: usize> From<Field<D>> for Operator<D> {
    fn from(function: Field<D>) -> Self {
        let (derivative, function) = (Derivative::identity(), Some(function));
        let source = Term { scale: 1.0, parameters: Vec::new(), function, derivative };
        Self { terms: Vec::new(), sources: vec![source] }
    }
}

impl<const D: usize> From<Derivative<D>> for Operator<D> {
    fn from(derivative: Derivative<D>) -> Self {
        let term = Term { scale: 1.0, parameters: Vec::new(), function: None, derivative };
        Self { terms: vec![term], sources: Vec::new() }
    }
}

impl<const D: usize> Mul for Derivative<D> {
    type Output = Self;
    fn mul(self, right: Self) -> Self {
        Self { orders: std::array::from_fn(|d| self.orders[d] + right.orders[d]) }
    }
}

impl<const D: usize> Mul<Derivative<D>> for Operator<D> {
    type Output = Self;
    /// First the derivative on the right, then this operator; known functions become factors of the derivative.
    fn mul(self, right: Derivative<D>) -> Self {
        let change = |term: Term<D>| Term { derivative: term.derivative * right, ..term };
        let all = self.terms.into_iter().chain(self.sources);
        Self { terms: all.map(change).collect(), sources: Vec::new() }
    }
}

/// Factors from the left: numbers and parameters.
macro_rules! factors {
    ($($Right:ty),*) => {$(
        impl<const D: usize> Mul<$Right> for f64 {
            type Output = Operator<D>;
            fn mul(self, right: $Right) -> Operator<D> {
                Operator::from(right).map(|term| Term { scale: self * term.scale, ..term })
            }
        }
        impl<const D: usize> Mul<$Right> for &Parameter {
            type Output = Operator<D>;
            fn mul(self, right: $Right) -> Operator<D> {
                Operator::from(right).map(|term| term.times(self))
            }
        }
    )*};
}
factors!(Operator<D>, Derivative<D>, Field<D>);

impl<const D: usize, R: Into<Operator<D>>> Mul<R> for Field<D> {
    type Output = Operator<D>;
    fn mul(self, right: R) -> Operator<D> {
        right.into().map(|term| {
            let own = term.function.map_or_else(|| self.clone(), |own| self.product(&own));
            Term { function: Some(own), ..term }
        })
    }
}

/// Signs and sums of operators and derivatives.
macro_rules! sums {
    ($($Left:ty),*) => {$(
        impl<const D: usize> Neg for $Left {
            type Output = Operator<D>;
            fn neg(self) -> Operator<D> {
                -1.0 * self
            }
        }
        impl<const D: usize, R: Into<Operator<D>>> Add<R> for $Left {
            type Output = Operator<D>;
            fn add(self, right: R) -> Operator<D> {
                let (mut sum, right) = (Operator::from(self), right.into());
                sum.terms.extend(right.terms);
                sum.sources.extend(right.sources);
                sum
            }
        }
        impl<const D: usize, R: Into<Operator<D>>> Sub<R> for $Left {
            type Output = Operator<D>;
            fn sub(self, right: R) -> Operator<D> {
                self + -1.0 * right.into()
            }
        }
    )*};
}
sums!(Operator<D>, Derivative<D>);

/// Σ weight · (L u)(point), a linear functional of u.
#[derive(Clone, Debug)]
pub struct Functional<const D: usize> {
    /// The operator L.
    pub operator: Operator<D>,
    /// Place of evaluation.
    pub points: Vec<[f64; D]>,
    /// Weight of each point.
    pub weights: Vec<f64>,
}

impl<const D: usize> Functional<D> {
    /// ∫ L u over a box, by Gauss–Legendre quadrature with `order` points along each axis.
    ///
    /// # Errors
    /// For domains with a polygon; give points and weights of your own there.
    pub fn integral(
        domain: &Domain<D>,
        operator: impl Into<Operator<D>>,
        order: usize,
    ) -> Result<Self> {
        Self::over(domain, operator.into(), order, None)
    }

    /// ∫ L u over the face at one end of an axis.
    ///
    /// # Errors
    /// As [`Functional::integral`]; and if there is no such axis.
    pub fn face_integral(
        domain: &Domain<D>,
        (axis, side): (&str, Side),
        operator: impl Into<Operator<D>>,
        order: usize,
    ) -> Result<Self> {
        Self::over(domain, operator.into(), order, Some((domain.axis(axis)?, side)))
    }

    fn over(
        domain: &Domain<D>,
        operator: Operator<D>,
        order: usize,
        face: Option<(usize, Side)>,
    ) -> Result<Self> {
        ensure!(
            domain.cross_section().is_none(),
            "the domain has a polygon; give points and weights of your own for the integral"
        );
        let along = |d: usize| match face {
            Some((axis, side)) if axis == d => (vec![domain.ends[d][side as usize]], vec![1.0]),
            _ => {
                let ([lower, _], extent) = (domain.ends[d], domain.extents()[d]);
                let rule = gauss_legendre(order.max(1)).into_iter();
                rule.map(|(s, w)| (lower + s * extent, w * extent)).unzip()
            }
        };
        let rules: [(Vec<f64>, Vec<f64>); D] = std::array::from_fn(along);
        let points = grid(&rules.each_ref().map(|rule| rule.0.clone()));
        let weights = grid(&rules.map(|rule| rule.1));
        let weights = weights.iter().map(|along| along.iter().product()).collect();
        Ok(Self { operator, points, weights })
    }
}

/// Nodes and weights of Gauss and Legendre for ∫ over [0, 1], from the spectrum of the Jacobi matrix of their polynomials (Golub &
/// Welsch 1969).
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let beside = |n: f64| n / (4.0 * n * n - 1.0).sqrt();
    let jacobi = DMatrix::from_fn(count, count, |i, j| match i.abs_diff(j) {
        1 => beside(i.max(j) as f64),
        _ => 0.0,
    });
    let eigen = jacobi.symmetric_eigen();
    let node = |k: usize| (0.5 * (1.0 + eigen.eigenvalues[k]), eigen.eigenvectors[(0, k)].powi(2));
    (0..count).map(node).collect()
}
