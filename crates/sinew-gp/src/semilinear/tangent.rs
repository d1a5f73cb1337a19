//! The linear equation that a semi-linear one is next to a solution.

use super::{SemiLinear, at_point, singular_term};
use crate::{Field, Operator, Result, Series, field};
use sinew_num::dot;
use std::collections::HashMap;
use std::sync::Arc;

/// The nonlinear term at one point to first order in arguments v and parameters θ, and in products of the two: factors in the order
/// of [`SemiLinear::tangent`], and what is added to f: g + g_v dv + g_θ dθ + g_vθ dv dθ, sorted by θ and u.
fn expanded(g: &Series, v: &[f64], theta: &[f64]) -> (Vec<f64>, f64) {
    let first = v.len();
    let slope = |of: &[usize]| {
        let mut orders = vec![0; first + theta.len()];
        of.iter().for_each(|k| orders[*k] = 1);
        g.derivative(&orders)
    };
    let mut factors = Vec::new();
    let mut alone: Vec<f64> = (0..theta.len()).map(|p| slope(&[first + p])).collect();
    let mut shift = dot(&alone, theta) - g.value();
    for (number, v) in v.iter().enumerate() {
        let both: Vec<f64> = (0..theta.len()).map(|p| slope(&[number, first + p])).collect();
        let own = slope(&[number]) - dot(&both, theta);
        shift += own * v;
        alone.iter_mut().zip(&both).for_each(|(alone, both)| *alone -= both * v);
        factors.push(own);
        factors.extend(both);
    }
    factors.extend(alone);
    (factors, shift)
}

impl<const D: usize, const M: usize> SemiLinear<D, M> {
    /// The operator linearised about `values` of the arguments and `theta` of the parameters, and at each point what is added
    /// to f.
    pub(super) fn tangent(
        &self,
        points: &[[f64; D]],
        values: &[Vec<f64>],
        theta: &[f64],
    ) -> Result<(Operator<D>, Vec<f64>)> {
        let count = theta.len();
        // By point: for each argument its factor alone, then times each parameter; then each parameter alone.
        let mut table = HashMap::new();
        let mut shifts = Vec::with_capacity(points.len());
        let degrees = vec![1; M + count];
        for (index, point) in points.iter().enumerate() {
            let v: [f64; M] = at_point(values, index);
            let numbers: Vec<f64> = v.iter().chain(theta).copied().collect();
            let variable = |k: usize| Series::variable(numbers[k], k, &degrees);
            let known: Vec<Series> = (M..M + count).map(variable).collect();
            let arguments: [Series; M] = std::array::from_fn(variable);
            let g = arguments[0].constant(0.0) + (self.term)(arguments, &known, *point);
            let (factors, shift) = expanded(&g, &v, theta);
            // Slopes that are not finite leave no finite shift either.
            if !shift.is_finite() {
                return Err(singular_term(index, &v));
            }
            shifts.push(shift);
            table.insert(point.map(f64::to_bits), factors);
        }
        let table = Arc::new(table);
        let mut fields = (0..).map(|column| tabulated(table.clone(), column));
        let mut next = || fields.next().expect("as many as are asked for");
        let mut equation = self.problem.equation().clone();
        for argument in self.arguments {
            equation = equation + next() * argument;
            for parameter in &self.parameters {
                equation = equation + parameter * (next() * argument);
            }
        }
        for parameter in &self.parameters {
            equation = equation + parameter * next();
        }
        Ok((equation, shifts))
    }
}

/// A function known at some points only, and NaN elsewhere.
fn tabulated<const D: usize>(table: Arc<HashMap<[u64; D], Vec<f64>>>, column: usize) -> Field<D> {
    field(move |x: [Series; D]| {
        let key = x.each_ref().map(|coordinate| coordinate.value().to_bits());
        x[0].constant(table.get(&key).map_or(f64::NAN, |factors| factors[column]))
    })
}
