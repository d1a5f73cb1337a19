//! Values that conditions impose at places of the boundary.

use crate::condition::Condition;
use crate::field::Field;
use crate::operator::{Derivative, Operator};
use crate::problem::Problem;
use crate::series::Series;

/// `value` u + ∂ⁿu = `data`, with the derivative of order n along a direction: that of the outward normal, but for periodic axes.
#[derive(Clone, Debug)]
pub(crate) struct Imposed<const D: usize> {
    pub value: Field<D>,
    pub order: usize,
    pub direction: [f64; D],
    pub data: Field<D>,
}

/// The derivative of `function` along a direction, of which the first components are given; the others are zero.
pub(crate) fn along<const D: usize>(
    function: &Field<D>,
    direction: &[f64],
    order: usize,
    x: &[Series; D],
) -> Series {
    if order == 0 {
        return function.at(x.clone());
    }
    let slope = |d: usize| direction.get(d).copied().unwrap_or_default();
    let lifted = std::array::from_fn(|d| x[d].lifted(order, slope(d)));
    function.at(lifted).last_derivative(order)
}

impl<const D: usize> Imposed<D> {
    /// All of a condition, with its outward normal.
    pub(crate) fn of(condition: &Condition<D>, direction: [f64; D]) -> Vec<Self> {
        let imposed = |value, order, data: &Field<D>| {
            let data = data.clone();
            Self { value, order, direction, data }
        };
        if let Condition::Robin { value_factor, data, .. } = condition {
            return vec![imposed(value_factor.clone(), 1, data)];
        }
        let given = condition.derivatives().into_iter();
        given.map(|(order, data)| imposed(Field::zero(), order, data)).collect()
    }

    /// The left-hand side as an operator.
    pub(crate) fn operator(&self) -> Operator<D> {
        let slope = Operator::along(self.direction, self.order);
        match self.value.is_zero() {
            true => slope,
            false => self.value.clone() * Derivative::identity() + slope,
        }
    }

    /// The left-hand side of a function, at `x` on the boundary.
    pub(crate) fn apply(&self, function: &Field<D>, x: &[Series; D]) -> Series {
        let slope = along(function, &self.direction, self.order, x);
        match self.value.is_zero() {
            true => slope,
            false => slope + function.at(x.clone()) * self.value.at(x.clone()),
        }
    }
}

/// Condition that a problem imposes on one edge of its polygon.
pub(crate) fn on_edge<const D: usize>(problem: &Problem<D>, number: usize) -> Vec<Imposed<D>> {
    let condition = problem.edges.get(number).and_then(Option::as_ref);
    let edge = problem.domain().cross_section().map(|polygon| &polygon.edges()[number]);
    let given = condition.zip(edge);
    given.map_or_else(Vec::new, |(condition, edge)| Imposed::of(condition, edge.outwards()))
}
