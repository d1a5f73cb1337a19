//! Values that conditions impose at places of the boundary.

use crate::{Condition, Derivative, Field, Operator, Series};

/// `value` u + ∂ⁿu = `data`, with the derivative of order n along the outward normal, but for periodic axes.
#[derive(Clone, Debug)]
pub(crate) struct Imposed<const D: usize> {
    pub value: Field<D>,
    pub order: usize,
    pub axis: usize,
    /// 1 where the normal points along the axis, −1 against it.
    pub outwards: f64,
    pub data: Field<D>,
}

/// The derivative of `function` along an axis.
pub(crate) fn along<const D: usize>(
    function: &Field<D>,
    axis: usize,
    order: usize,
    x: &[Series; D],
) -> Series {
    if order == 0 {
        return function.at(x.clone());
    }
    let slope = |d: usize| if d == axis { 1.0 } else { 0.0 };
    let lifted = std::array::from_fn(|d| x[d].lifted(order, slope(d)));
    function.at(lifted).last_derivative(order)
}

impl<const D: usize> Imposed<D> {
    /// All of a condition, with the axis of its outward normal and the sign along it.
    pub(crate) fn of(condition: &Condition<D>, axis: usize, outwards: f64) -> Vec<Self> {
        let imposed = |value, order, data: &Field<D>| {
            let data = data.clone();
            Self { value, order, axis, outwards, data }
        };
        if let Condition::Robin { value_factor, data, .. } = condition {
            return vec![imposed(value_factor.clone(), 1, data)];
        }
        let given = condition.derivatives().into_iter();
        given.map(|(order, data)| imposed(Field::zero(), order, data)).collect()
    }

    /// Sign of the derivative along the normal, in units of that along the axis.
    pub(crate) fn sign(&self) -> f64 {
        self.outwards.powi(self.order as i32)
    }

    /// The left-hand side as an operator.
    pub(crate) fn operator(&self) -> Operator<D> {
        let mut orders = [0; D];
        orders[self.axis] = self.order;
        let slope = self.sign() * Derivative { orders };
        match self.value.is_zero() {
            true => slope,
            false => self.value.clone() * Derivative::identity() + slope,
        }
    }

    /// The left-hand side of a function, at `x` on the boundary.
    pub(crate) fn apply(&self, function: &Field<D>, x: &[Series; D]) -> Series {
        let slope = along(function, self.axis, self.order, x) * self.sign();
        match self.value.is_zero() {
            true => slope,
            false => slope + function.at(x.clone()) * self.value.at(x.clone()),
        }
    }
}
