//! The gradient of the evidence, from the cotangents of covariance and residual.

use crate::coefficients::monomial_slope;
use crate::compile::Variance;
use crate::gram::{Cotangents, Scratch};
use crate::inverse::invert_lower;
use crate::optimise::dot;
use crate::state::{Factored, State};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

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
    /// With W the rows from `split` on of L⁻¹, z = L⁻¹ r, w = Wᵀ z_u, a = L_ff⁻ᵀ z_f and τ the weight of the rows
    /// before, they are ½(WᵀW − wwᵀ − waᵀ − awᵀ) + ½τ(K_ff⁻¹ − aaᵀ) and w + τa.
    fn cotangents(&self, factored: &Factored) -> (Vec<f64>, Vec<f64>) {
        let (size, split, par) = (self.model.size, self.first_row(), self.threads());
        let weight = self.weight();
        let rest = size - split;
        let lower = factored.factor.view();
        let mut memory = vec![0.0; rest * rest];
        let mut inverse = square(&mut memory, rest);
        let left = inverted(lower, inverse.rb_mut(), split, par);
        let mut entries = vec![0.0; size * size];
        let cotangent = square(&mut entries, size);
        let (left, inverse) = (left.as_ref(), inverse.rb());
        self.fill(cotangent, lower, (left, inverse));

        let (head, tail) = factored.whitened.split_at(split);
        let of_w = |column: usize| -> f64 {
            match column.checked_sub(split) {
                None => left.col(column).iter().zip(tail).map(|(l, z)| l * z).sum(),
                Some(c) => inverse.col(c).iter().zip(tail).skip(c).map(|(l, z)| l * z).sum(),
            }
        };
        let mut w: Vec<f64> = match self.parallel() {
            true => (0..size).into_par_iter().map(of_w).collect(),
            false => (0..size).map(of_w).collect(),
        };
        let mut a = vec![0.0; size];
        a[..split].copy_from_slice(head);
        factored.factor.backward(&mut a[..split]);
        let subtract = |(column, rows): (usize, &mut [f64])| {
            let (w_column, a_column) = (w[column], a[column]);
            for row in column..size {
                rows[row] -=
                    w[row] * (w_column + a_column) + a[row] * (w_column + weight * a_column);
            }
            // Half of it on the diagonal, twice the half for the pair off it.
            rows[column] *= 0.5;
        };
        match self.parallel() {
            true => entries.par_chunks_mut(size).enumerate().for_each(subtract),
            false => entries.chunks_mut(size).enumerate().for_each(subtract),
        }
        w.iter_mut().zip(&a).for_each(|(w, a)| *w += weight * a);
        (entries, w)
    }

    /// Lower triangle of `Wᵀ W` for `W = [left | inverse]`, and of the imposed rows' own inverse by its weight.
    fn fill(
        &self,
        mut cotangent: MatMut<'_, f64>,
        lower: MatRef<'_, f64>,
        (left, inverse): (MatRef<'_, f64>, MatRef<'_, f64>),
    ) {
        let (split, par, weight) = (self.first_row(), self.threads(), self.weight());
        let rest = self.model.size - split;
        let full = BlockStructure::Rectangular;
        let (low, high) = (BlockStructure::TriangularLower, BlockStructure::TriangularUpper);
        if split > 0 {
            let corner = cotangent.rb_mut().submatrix_mut(0, 0, split, split);
            matmul(corner, low, Accum::Replace, left.transpose(), full, left, full, 1.0, par);
            let below = cotangent.rb_mut().submatrix_mut(split, 0, rest, split);
            matmul(below, full, Accum::Replace, inverse.transpose(), high, left, full, 1.0, par);
            let mut memory = vec![0.0; split * split];
            let mut imposed = square(&mut memory, split);
            invert_lower(imposed.rb_mut(), lower.submatrix(0, 0, split, split), par);
            let (upper, imposed) = (imposed.rb().transpose(), imposed.rb());
            let corner = cotangent.rb_mut().submatrix_mut(0, 0, split, split);
            matmul(corner, low, Accum::Add, upper, high, imposed, low, weight, par);
        }
        let corner = cotangent.rb_mut().submatrix_mut(split, split, rest, rest);
        matmul(corner, low, Accum::Replace, inverse.transpose(), high, inverse, low, 1.0, par);
    }

    /// Gradient of ln evidence in all parameters, on their scales.
    pub(crate) fn gradient(&self, factored: &Factored) -> Vec<f64> {
        let size = self.model.size;
        let (mut cotangent, w) = self.cotangents(factored);
        let mut noise = Vec::new();
        for (number, group) in self.model.groups.iter().enumerate() {
            let (mut trace, sigma) = (0.0, self.noise[number]);
            for (own, row) in group.rows().enumerate() {
                let diagonal = &mut cotangent[row * (size + 1)];
                let slope = *diagonal * sigma * sigma / self.weights[number][own];
                trace += slope;
                if let Variance::StudentT { weights, .. } = group.variance {
                    noise.push((weights + own, -slope));
                }
                *diagonal *= 1.0 + factored.jitter;
            }
            if let Some(position) = group.variance.learned() {
                noise.push((position, 2.0 * trace - group.scatter(sigma).1));
            }
        }
        let mut gradient = self.propagated(&cotangent, &w);
        noise.into_iter().for_each(|(position, slope)| gradient[position] += slope);
        gradient.iter_mut().for_each(|g| *g = -*g);
        gradient
    }

    /// Gradient in all parameters but the noise, on their scales, from cotangents of the covariance (as
    /// [`State::cotangents`] has them) and of the residual.
    pub(crate) fn propagated(&self, cotangent: &[f64], w: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; self.model.parameters.len()];
        let pulled = self.pull_back(cotangent);
        let mut theta = vec![0.0; self.theta.len()];
        for group in &self.model.groups {
            let monomials = &group.legs[0].monomials;
            let mut slopes = vec![0.0; monomials.len()];
            let rows = &w[group.rows()];
            for (number, leg) in (group.first_leg..).zip(&group.legs) {
                for part in 0..self.kernels.len() {
                    let position = part * self.model.legs + number;
                    let slot = &pulled.coefficients[position];
                    gradient[self.model.part_offsets[part]] +=
                        dot(slot, &self.coefficients[position]);
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
        gradient
    }

    fn pull_back(&self, cotangent: &[f64]) -> Pulled {
        let size = self.model.size;
        let lots = if self.is_large() { LOTS } else { 1 };
        let lot = |lot: usize| {
            let mut pulled = Pulled::zeros(self);
            let mut scratch = Scratch::default();
            // Interleaved, because early columns are longer.
            for column in (lot..size).step_by(lots) {
                self.pull_column(
                    column,
                    &cotangent[column * size..(column + 1) * size],
                    &mut pulled,
                    &mut scratch,
                );
            }
            pulled
        };
        if lots == 1 {
            return lot(0);
        }
        let parts: Vec<Pulled> = (0..lots).into_par_iter().map(lot).collect();
        let mut sum = Pulled::zeros(self);
        parts.iter().for_each(|part| sum.add(part));
        sum
    }

    fn pull_column(
        &self,
        column: usize,
        weights: &[f64],
        pulled: &mut Pulled,
        scratch: &mut Scratch,
    ) {
        let second = self.group_of(column);
        let own = column - self.model.groups[second].offset;
        for part in 0..self.kernels.len() {
            for first in second..self.model.groups.len() {
                let (start, rows) = self.rows(first, column);
                for (first, second) in self.leg_pairs(first, second) {
                    let block = self.block(part, first, second);
                    let leg = &self.model.groups[second[0]].legs[second[1]];
                    // The cotangents of the column's own point come back apart, for it may lie in the same group as the rows.
                    pulled.own.clear();
                    pulled.own.resize(leg.parts[part].orders.len(), 0.0);
                    let mut cotangents = Cotangents {
                        first: &mut pulled.coefficients[self.slot(part, first)],
                        second: &mut pulled.own,
                        hyperparameters: &mut pulled.hyperparameters[part],
                    };
                    let weights = &weights[rows.clone()];
                    block.pull_column(start, own, weights, &mut cotangents, scratch);
                    let slots = &mut pulled.coefficients[self.slot(part, second)];
                    let slots = slots.iter_mut().skip(own).step_by(leg.count);
                    slots.zip(&pulled.own).for_each(|(slot, value)| *slot += value);
                }
            }
        }
    }
}

/// Cotangents of coefficients and kernel parameters.
struct Pulled {
    coefficients: Vec<Vec<f64>>,
    hyperparameters: Vec<Vec<f64>>,
    own: Vec<f64>,
}

impl Pulled {
    fn zeros<const D: usize>(state: &State<'_, D>) -> Self {
        let zeros = |v: &Vec<f64>| vec![0.0; v.len()];
        Self {
            coefficients: state.coefficients.iter().map(zeros).collect(),
            hyperparameters: state.kernels.iter().map(|(_, h)| zeros(h)).collect(),
            own: Vec::new(),
        }
    }

    fn add(&mut self, other: &Self) {
        let to = self.coefficients.iter_mut().chain(&mut self.hyperparameters).flatten();
        let from = other.coefficients.iter().chain(&other.hyperparameters).flatten();
        to.zip(from).for_each(|(to, from)| *to += from);
    }
}

/// Inverse of the trailing block of a factor; `left = −L_uu⁻¹ L_uf L_ff⁻¹`, so that `[left | inverse]` is the trailing part of L⁻¹.
fn inverted(
    lower: MatRef<'_, f64>,
    mut inverse: MatMut<'_, f64>,
    split: usize,
    par: Par,
) -> Mat<f64> {
    let rest = lower.nrows() - split;
    invert_lower(inverse.rb_mut(), lower.submatrix(split, split, rest, rest), par);
    let mut left = Mat::<f64>::zeros(rest, split);
    if split > 0 {
        let below = lower.submatrix(split, 0, rest, split);
        let (full, low) = (BlockStructure::Rectangular, BlockStructure::TriangularLower);
        matmul(left.as_mut(), full, Accum::Replace, inverse.rb(), low, below, full, -1.0, par);
        let leading = lower.submatrix(0, 0, split, split);
        solve_upper_triangular_in_place(leading.transpose(), left.as_mut().transpose_mut(), par);
    }
    left
}
