//! A condition on one edge as functionals.

use crate::condition::Condition;
use crate::edge::Edge;
use crate::field::{Field, constant};
use crate::operator::{Derivative, Operator};
use crate::problem::Problem;
use crate::series::Series;

/// a u + b ∂u/∂n = data on an edge, n pointing outwards.
#[derive(Clone, Debug)]
pub(crate) struct EdgeLift<const D: usize> {
    pub value: Field<D>,
    pub slope: f64,
    pub data: Field<D>,
    pub edge: Edge,
}

/// The derivative of `function` along a direction in the plane.
pub(super) fn along<const D: usize>(
    function: &Field<D>,
    [dx, dy]: [f64; 2],
    x: &[Series; D],
) -> Series {
    let mut lifted = x.each_ref().map(|coordinate| coordinate.lifted(1));
    let step = lifted[0].shifted_last_variable(0.0);
    lifted[0] = &lifted[0] + &step * dx;
    lifted[1] = &lifted[1] + &step * dy;
    function.at(lifted).last_derivative(1)
}

impl<const D: usize> EdgeLift<D> {
    /// All of a condition.
    pub(crate) fn of(condition: &Condition<D>, edge: &Edge) -> Vec<Self> {
        let lift = |value, slope, data: &Field<D>| Self {
            value,
            slope,
            data: data.clone(),
            edge: edge.clone(),
        };
        if let Condition::Robin { value_factor, data, .. } = condition {
            return vec![lift(value_factor.clone(), 1.0, data)];
        }
        let given = condition.derivatives().into_iter();
        given
            .map(|(order, data)| match order {
                0 => lift(constant(1.0), 0.0, data),
                _ => lift(Field::zero(), 1.0, data),
            })
            .collect()
    }

    /// Outward normal.
    pub(crate) fn outwards(&self) -> [f64; 2] {
        self.edge.normal.map(|n| -n)
    }

    /// a u + b ∂u/∂n as an operator.
    pub(crate) fn operator(&self) -> Operator<D> {
        let [nx, ny] = self.outwards().map(|n| n * self.slope);
        let slope = nx * Derivative::along(0) + ny * Derivative::along(1);
        let value = self.value.clone() * Derivative::identity();
        match (self.value.is_zero(), self.slope == 0.0) {
            (true, _) => slope,
            (false, true) => value,
            (false, false) => value + slope,
        }
    }

    /// a u + b ∂u/∂n of a function, at `x` on the edge.
    pub(crate) fn apply(&self, function: &Field<D>, x: &[Series; D]) -> Series {
        let mut sum = x[0].constant(0.0);
        if !self.value.is_zero() {
            sum = sum + function.at(x.clone()) * self.value.at(x.clone());
        }
        if self.slope != 0.0 {
            sum = sum + along(function, self.outwards(), x) * self.slope;
        }
        sum
    }
}

/// The conditions of a problem on one edge of its polygon.
pub(crate) fn edge_lifts<const D: usize>(problem: &Problem<D>, number: usize) -> Vec<EdgeLift<D>> {
    let condition = problem.edges.get(number).and_then(Option::as_ref);
    let edge = problem.domain().cross_section().map(|polygon| &polygon.edges()[number]);
    condition
        .into_iter()
        .zip(edge)
        .flat_map(|(condition, edge)| EdgeLift::of(condition, edge))
        .collect()
}
