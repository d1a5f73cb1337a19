//! The linear equation that a semi-linear one is next to a solution.

use super::{SemiLinear, singular_term};
use crate::error::GpError;
use crate::field::{Field, field};
use crate::operator::Operator;
use crate::series::Series;
use std::collections::HashMap;

/// The nonlinear term at one point to first order in arguments v and parameters θ, and in products of the two.
struct Expansion<'a> {
    g: Series,
    v: &'a [f64],
    theta: &'a [f64],
}

impl Expansion<'_> {
    /// The derivative in each of these variables once: arguments first, then parameters.
    fn slope(&self, of: &[usize]) -> f64 {
        let mut orders = vec![0; self.v.len() + self.theta.len()];
        of.iter().for_each(|k| orders[*k] = 1);
        self.g.derivative(&orders)
    }

    /// Factors in the order of [`SemiLinear::tangent`], and what is added to f: g + g_v dv + g_θ dθ + g_vθ dv dθ, sorted by θ
    /// and u.
    fn sorted(&self) -> (Vec<f64>, f64) {
        let first = self.v.len();
        let mut factors = Vec::new();
        let mut alone: Vec<f64> = (0..self.theta.len()).map(|p| self.slope(&[first + p])).collect();
        let mut shift = -self.g.value();
        shift += alone.iter().zip(self.theta).map(|(slope, t)| slope * t).sum::<f64>();
        for (number, v) in self.v.iter().enumerate() {
            let own = self.slope(&[number]);
            let both: Vec<f64> =
                (0..self.theta.len()).map(|p| self.slope(&[number, first + p])).collect();
            let bound: f64 = both.iter().zip(self.theta).map(|(slope, t)| slope * t).sum();
            shift += (own - bound) * v;
            alone.iter_mut().zip(&both).for_each(|(alone, both)| *alone -= both * v);
            factors.push(own - bound);
            factors.extend(both);
        }
        factors.extend(alone);
        (factors, shift)
    }
}

impl<const D: usize, const M: usize> SemiLinear<D, M> {
    /// The operator linearised about `values` of the arguments and `theta` of the parameters, and at each point what is added
    /// to f.
    pub(super) fn tangent(
        &self,
        points: &[[f64; D]],
        values: &[[f64; M]],
        theta: &[f64],
    ) -> Result<(Operator<D>, Vec<f64>), GpError> {
        let count = theta.len();
        // For each argument its factor alone, then times each parameter; then each parameter alone.
        let mut tables = vec![HashMap::new(); M * (count + 1) + count];
        let mut shifts = Vec::with_capacity(points.len());
        let degrees = vec![1; M + count];
        for (index, (point, v)) in points.iter().zip(values).enumerate() {
            let numbers: Vec<f64> = v.iter().chain(theta).copied().collect();
            let variable = |k: usize| Series::variable(numbers[k], k, &degrees);
            let known: Vec<Series> = (M..M + count).map(variable).collect();
            let arguments: [Series; M] = std::array::from_fn(variable);
            let g = arguments[0].constant(0.0) + (self.term)(arguments, &known, *point);
            let (factors, shift) = Expansion { g, v, theta }.sorted();
            // Slopes that are not finite leave no finite shift either.
            if !shift.is_finite() {
                return Err(singular_term(index, v));
            }
            shifts.push(shift);
            for (table, factor) in tables.iter_mut().zip(factors) {
                table.insert(point.map(f64::to_bits), factor);
            }
        }
        let mut tables = tables.into_iter().map(tabulated);
        let mut next = || tables.next().expect("as many as were made");
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
fn tabulated<const D: usize>(values: HashMap<[u64; D], f64>) -> Field<D> {
    field(move |x: [Series; D]| {
        let key = x.each_ref().map(|coordinate| coordinate.value().to_bits());
        x[0].constant(values.get(&key).copied().unwrap_or(f64::NAN))
    })
}
