//! Lengths that an equation suggests.

use crate::kernel::Measure;
use crate::model::Model;
use crate::operator::Term;
use std::f64::consts::PI;

impl<const D: usize> Model<D> {
    /// Moves the lengthscales of a start, drawn for functions that vary over the whole domain, to the half waves that the equation
    /// has at its parameters where these are shorter: sin kx of u″ + k² u = 0, a layer exp(−x √(k/D)) of D u″ = k u.
    pub(crate) fn scale_lengths(&self, start: &mut [f64]) {
        let theta = self.theta_values(start);
        let lengths: [f64; D] = std::array::from_fn(|axis| self.half_wave(axis, &theta));
        for (part, offset) in self.prior.parts.iter().zip(&self.part_offsets) {
            for (k, hyperparameter) in part.kernel.hyperparameters().iter().enumerate() {
                if let Measure::Length { axis } = hyperparameter.measure {
                    start[offset + 1 + k] += lengths[axis].min(1.0).ln();
                }
            }
        }
    }

    /// Half a wave along an axis in units of its extent: π times the least length on which a term of the highest order along it
    /// balances one of a lower order, with derivatives along other axes of the size of their extents.
    fn half_wave(&self, axis: usize, theta: &[f64]) -> f64 {
        let terms = self.prior.equation.terms();
        let order = |term: &Term<D>| term.derivative.orders[axis];
        let most = terms.iter().map(order).max().unwrap_or(0);
        let size_of = |own: usize| {
            let sizes = terms.iter().filter(|term| order(term) == own);
            sizes.map(|term| self.term_size(term, theta)).fold(0.0, f64::max)
        };
        let lengths = (0..most)
            .map(|lower| (size_of(most) / size_of(lower)).powf(((most - lower) as f64).recip()));
        PI * lengths.filter(|length| *length > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// Size of a term on functions of size one that vary over the whole domain, in its middle.
    fn term_size(&self, term: &Term<D>, theta: &[f64]) -> f64 {
        let domain = &self.prior.domain;
        let powers = term.parameters.iter().map(|(own, power)| {
            let known = self.theta.iter().position(|other| other == own);
            known.map_or(1.0, |k| theta[k].powi(*power))
        });
        let middle = std::array::from_fn(|d| 0.5 * (domain.lower()[d] + domain.upper()[d]));
        let function = term.function.as_ref().map_or(1.0, |function| function.value(middle));
        let extents = domain.extents().into_iter().zip(term.derivative.orders);
        let shrink = extents.map(|(extent, n)| extent.powi(-(n as i32)));
        (term.scale * function * powers.chain(shrink).product::<f64>()).abs()
    }
}
