//! Functions on a domain, written once for values and derivatives.

use crate::series::Series;
use std::fmt;
use std::sync::Arc;

type Function<const D: usize> = dyn Fn([Series; D]) -> Series + Send + Sync;

/// A function of the coordinates, given as one formula over [`Series`], from which its values
/// and derivatives of any order follow.
#[derive(Clone)]
pub struct Field<const D: usize> {
    /// `None` for the zero function, which needs no work.
    function: Option<Arc<Function<D>>>,
}

/// The function with the formula `formula` in the coordinates.
///
/// ```
/// let bump = sinew_gp::field(|[x, t]| x.sin() * (-t).exp());
/// assert_eq!(bump.value([0.5, 0.0]), 0.5_f64.sin());
/// ```
pub fn field<const D: usize>(
    formula: impl Fn([Series; D]) -> Series + Send + Sync + 'static,
) -> Field<D> {
    Field { function: Some(Arc::new(formula)) }
}

/// The function that is `value` everywhere.
pub fn constant<const D: usize>(value: f64) -> Field<D> {
    let everywhere = field(move |x: [Series; D]| x[0].constant(value));
    if value == 0.0 { Field { function: None } } else { everywhere }
}

impl<const D: usize> Field<D> {
    /// Whether it is known to vanish everywhere.
    pub(crate) fn is_zero(&self) -> bool {
        self.function.is_none()
    }

    /// The formula at `x`.
    pub fn at(&self, x: [Series; D]) -> Series {
        let zero = x[0].constant(0.0);
        match &self.function {
            // A formula that ignores the coordinates may return a constant of a shape of its own.
            Some(function) => zero + function(x),
            None => zero,
        }
    }

    /// Derivative along an axis.
    pub(crate) fn derivative_along(&self, axis: usize, order: usize, x: &[Series; D]) -> Series {
        if order == 0 {
            return self.at(x.clone());
        }
        let slope = |d: usize| if d == axis { 1.0 } else { 0.0 };
        let lifted = std::array::from_fn(|d| x[d].lifted(order, slope(d)));
        self.at(lifted).last_derivative(order)
    }

    /// Product of two functions.
    pub(crate) fn product(&self, other: &Self) -> Self {
        let (own, other) = (self.clone(), other.clone());
        field(move |x: [Series; D]| own.at(x.clone()) * other.at(x))
    }

    /// Value at `x`.
    pub fn value(&self, x: [f64; D]) -> f64 {
        self.at(Series::plain(x)).value()
    }
}

impl<const D: usize> fmt::Debug for Field<D> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(if self.is_zero() { "Field(0)" } else { "Field(..)" })
    }
}
