//! The gradient of the evidence, from the cotangents of covariance and residual.

use crate::evidence::factor::{for_columns, invert_lower};
use crate::evidence::gram::Scratch;
use crate::evidence::state::{Factored, State};
use crate::prior::coefficients::monomial_slope;
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::reborrow::Reborrow;
use faer::{Accum, MatMut};
use sinew_num::{dot, in_parallel};

/// Columns are shared out in this many lots, whatever the number of threads, so that sums do not
/// depend on it.
const LOTS: usize = 32;

fn square(memory: &mut [f64], size: usize) -> MatMut<'_, f64> {
    MatMut::from_column_major_slice_mut(memory, size, size)
}

impl<const D: usize> State<'_, D> {
    /// Cotangents of −ln evidence: of the covariance (lower triangle, as if its entries were
    /// independent and each off-diagonal one counted twice) and of the residual.
    ///
    /// With z = L⁻¹ r, w = L⁻ᵀ (0, z_u), a = L⁻ᵀ_ff z_f and τ the weight of the imposed rows f, they are
    /// ½(L⁻ᵀ diag(τ, 1) L⁻¹ − wwᵀ − waᵀ − awᵀ − τaaᵀ) and w + τa.
    fn cotangents(&self, factored: &Factored) -> (Vec<f64>, Vec<f64>) {
        let (size, split, par) = (self.model.size, self.first_row(), self.threads());
        let (weight, factor) = (self.weight(), &factored.factor);
        let mut inverse = vec![0.0; size * size];
        invert_lower(square(&mut inverse, size), factor.view(), par);
        for (column, rows) in inverse.chunks_mut(size).enumerate().take(split) {
            rows[column..split].iter_mut().for_each(|entry| *entry *= weight.sqrt());
        }
        let mut entries = vec![0.0; size * size];
        let (low, high) = (BlockStructure::TriangularLower, BlockStructure::TriangularUpper);
        let (cotangent, inverse) = (square(&mut entries, size), square(&mut inverse, size));
        let upper = inverse.rb().transpose();
        matmul(cotangent, low, Accum::Replace, upper, high, inverse.rb(), low, 1.0, par);

        let (mut a, mut w) = (factored.whitened.clone(), factored.whitened.clone());
        a[split..].fill(0.0);
        factor.backward(&mut a[..split]);
        w[..split].fill(0.0);
        factor.backward(&mut w);
        let subtract = |(column, rows): (usize, &mut [f64]), (): &mut ()| {
            let (w_column, a_column) = (w[column], a[column]);
            for row in column..size {
                rows[row] -=
                    w[row] * (w_column + a_column) + a[row] * (w_column + weight * a_column);
            }
            // Half of it on the diagonal, twice the half for the pair off it.
            rows[column] *= 0.5;
        };
        for_columns(par, (&mut entries, size), subtract);
        w.iter_mut().zip(&a).for_each(|(w, a)| *w += weight * a);
        (entries, w)
    }

    /// Gradient of ln evidence in all parameters, on their scales.
    pub(crate) fn gradient(&self, factored: &Factored) -> Vec<f64> {
        let size = self.model.size;
        let (mut cotangent, w) = self.cotangents(factored);
        let mut gradient = vec![0.0; self.model.parameters.len()];
        for (number, group) in self.model.groups.iter().enumerate() {
            let (mut trace, sigma) = (0.0, self.noise[number]);
            for (own, row) in group.rows().enumerate() {
                let diagonal = &mut cotangent[row * (size + 1)];
                let share = factored.shares[row];
                let noise =
                    if share > 0.0 { 0.0 } else { sigma * sigma / self.weights[number][own] };
                let slope = *diagonal * noise;
                trace += slope;
                group.weighted.iter().for_each(|first| gradient[first + own] -= slope);
                *diagonal *= 1.0 + share;
            }
            let slope = 2.0 * trace - group.scatter(sigma).1;
            group.learned.iter().for_each(|position| gradient[*position] += slope);
        }
        self.propagate(&cotangent, &w, &mut gradient);
        gradient.iter_mut().for_each(|g| *g = -*g);
        gradient
    }

    /// Adds the gradient in all parameters but the noise, on their scales, from cotangents of the covariance (as
    /// [`State::cotangents`] has them) and of the residual.
    fn propagate(&self, cotangent: &[f64], w: &[f64], gradient: &mut [f64]) {
        let pulled = self.pull_back(cotangent);
        let mut theta = vec![0.0; self.theta.len()];
        for group in &self.model.groups {
            let monomials = &group.legs[0].monomials;
            let mut slopes = vec![0.0; monomials.len()];
            let rows = &w[group.rows()];
            for (number, leg) in (group.first_leg..).zip(&group.legs) {
                for (part, slot) in pulled.coefficients[number].iter().enumerate() {
                    gradient[self.model.part_offsets[part]] +=
                        dot(slot, &self.legs[number].coefficients[part]);
                    let amplitude = self.kernels[part].0;
                    for (slope, array) in slopes.iter_mut().zip(&leg.parts[part].arrays) {
                        *slope += amplitude * dot(slot, array);
                    }
                }
                for (slope, mean) in slopes.iter_mut().zip(&leg.mean) {
                    *slope -= dot(rows, mean);
                }
            }
            for (slope, monomial) in slopes.iter().zip(monomials) {
                for (position, _) in monomial {
                    theta[*position] += slope * monomial_slope(monomial, &self.theta, *position);
                }
            }
        }
        for (position, slope) in theta.into_iter().enumerate() {
            let parameter = &self.model.parameters[self.model.theta_offset + position];
            let scale = if parameter.logarithmic { self.theta[position] } else { 1.0 };
            gradient[self.model.theta_offset + position] = slope * scale;
        }
        for (offset, slopes) in self.model.part_offsets.iter().zip(&pulled.hyperparameters) {
            gradient[offset + 1..offset + 1 + slopes.len()].copy_from_slice(slopes);
        }
    }

    fn pull_back(&self, cotangent: &[f64]) -> Pulled {
        let size = self.model.size;
        let lots = if self.is_large() { LOTS } else { 1 };
        let lot = |lot: usize| {
            let mut pulled = Pulled::zeros(self);
            // Interleaved, because early columns are longer.
            for column in (lot..size).step_by(lots) {
                self.pull_column(column, cotangent, &mut pulled);
            }
            pulled
        };
        if lots == 1 {
            return lot(0);
        }
        let mut sum = Pulled::zeros(self);
        in_parallel(0..lots, lot).iter().for_each(|part| sum.add(part));
        sum
    }

    fn pull_column(&self, column: usize, cotangent: &[f64], pulled: &mut Pulled) {
        let Pulled { coefficients, hyperparameters, scratch } = pulled;
        let weights = &cotangent[column * self.model.size..];
        let group = self.group_of(column);
        let seconds = self.legs_of(group);
        let own = column - self.model.groups[group].offset;
        for part in 0..self.kernels.len() {
            for first in seconds.start..self.legs.len() {
                let (start, rows) = self.rows(self.legs[first].group, column);
                for second in seconds.clone() {
                    let block = self.block(part, first, second);
                    let leg = self.legs[second].points;
                    let memory = [&mut coefficients[first][part], &mut hyperparameters[part]];
                    block.pull_column(start, own, &weights[rows.clone()], memory, scratch);
                    // Apart, because the column's own point may lie in the same group as the rows.
                    let slots = coefficients[second][part].iter_mut().skip(own);
                    let slots = slots.step_by(leg.count).zip(&scratch.own);
                    slots.for_each(|(slot, value)| *slot += value);
                }
            }
        }
    }
}

/// Cotangents of coefficients and kernel parameters, with the memory that one thread adds them up in.
struct Pulled {
    /// Cotangents of the coefficients, by leg and part.
    coefficients: Vec<Vec<Vec<f64>>>,
    hyperparameters: Vec<Vec<f64>>,
    /// Not part of the sum.
    scratch: Scratch,
}

impl Pulled {
    fn zeros<const D: usize>(state: &State<'_, D>) -> Self {
        let zeros = |all: &Vec<Vec<f64>>| all.iter().map(|v| vec![0.0; v.len()]).collect();
        Self {
            coefficients: state.legs.iter().map(|leg| zeros(&leg.coefficients)).collect(),
            hyperparameters: state.kernels.iter().map(|(_, h)| vec![0.0; h.len()]).collect(),
            scratch: Scratch::default(),
        }
    }

    fn add(&mut self, other: &Self) {
        let to = self.coefficients.iter_mut().flatten().chain(&mut self.hyperparameters);
        let from = other.coefficients.iter().flatten().chain(&other.hyperparameters);
        to.flatten().zip(from.flatten()).for_each(|(to, from)| *to += from);
    }
}
