//! Lengths of the waves of an equation.

use crate::{Measure, Model, Term};
use std::f64::consts::PI;

impl<const D: usize> Model<D> {
    /// Moves the lengthscales of a start, drawn for functions that vary over the whole domain, to the half waves that solve the
    /// equation at its parameters, where these are shorter: of sin kx for u″ + k² u = 0.
    pub(crate) fn scale_lengths(&self, start: &mut [f64]) {
        let theta = self.theta_values(start);
        let waves: [f64; D] = std::array::from_fn(|axis| self.half_wave(axis, &theta));
        for (part, offset) in self.prior.parts.iter().zip(&self.part_offsets) {
            for (k, hyperparameter) in part.kernel.hyperparameters().iter().enumerate() {
                if let Measure::Length { axis } = hyperparameter.measure {
                    start[offset + 1 + k] += waves[axis].min(1.0).ln();
                }
            }
        }
    }

    /// Shortest half wave along an axis in units of its extent for which a term of the highest order along it cancels one of a lower
    /// order; infinite where none does.
    fn half_wave(&self, axis: usize, theta: &[f64]) -> f64 {
        let of = |term: &Term<D>| (term.derivative.orders[axis], self.symbol(term, theta));
        let terms: Vec<(usize, f64)> = self.prior.equation.terms().iter().map(of).collect();
        let most = terms.iter().map(|(order, _)| *order).max().unwrap_or(0);
        let lower = terms.iter().filter(|(order, _)| *order < most);
        let highest = || terms.iter().filter(|(order, _)| *order == most);
        let pairs = lower.flat_map(|low| highest().map(move |high| (low, high)));
        let length = |((order, low), (_, high)): (&(usize, f64), &(usize, f64))| {
            (-high / low).powf(((most - order) as f64).recip())
        };
        PI * pairs.map(length).filter(|length| *length > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// Fourier symbol of a term at a wavenumber of one over the extent along each axis, in the middle of the domain; 0 where it is
    /// imaginary.
    fn symbol(&self, term: &Term<D>, theta: &[f64]) -> f64 {
        let (domain, orders) = (&self.prior.domain, term.derivative.orders);
        let powers = term.parameters.iter().map(|(own, power)| {
            let known = self.theta.iter().position(|other| other == own);
            known.map_or(1.0, |k| theta[k].powi(*power))
        });
        let middle = domain.ends.map(|[lower, upper]| 0.5 * (lower + upper));
        let function = term.function.as_ref().map_or(1.0, |function| function.value(middle));
        let shrink = domain.extents().into_iter().zip(orders).map(|(l, n)| l.powi(-(n as i32)));
        let turned = [1.0, 0.0, -1.0, 0.0][orders.iter().sum::<usize>() % 4];
        turned * term.scale * function * powers.chain(shrink).product::<f64>()
    }
}
