//! The evidence of a model and its gradient, by one Cholesky factorisation.

use std::f64::consts::PI;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

use crate::error::GpError;
use crate::gram::{Block, Cotangents, Scratch, Side};
use crate::inverse::invert_lower;
use crate::model::{Compiled, Model, Variance, monomial_slope, monomial_value};

/// What a fit maximises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Evidence {
    /// ln p(y_u, y_f) (4.18). Unbounded where noise-free collocation is met by the prior mean
    /// itself, be it as θ → 0: a covariance K_ff → 0 then makes the collocation values as likely
    /// as one likes, and u is lost.
    Joint,
    /// ln p(y_u | y_f): how well what is imposed (the equation, and pseudo-observations of the
    /// boundary) predicts what is measured.
    Conditional,
    /// Conditional where the joint evidence is unbounded, and joint elsewhere.
    #[default]
    Auto,
}

impl Evidence {
    pub(crate) fn resolve<const D: usize>(
        self,
        groups: &[Compiled<D>],
        imposed: usize,
        size: usize,
    ) -> Result<Self, GpError> {
        let unbounded = groups.iter().any(Compiled::is_trivially_satisfied);
        match self {
            Self::Conditional if imposed == size => Err(GpError::NothingConditional),
            Self::Auto if unbounded && imposed < size => Ok(Self::Conditional),
            Self::Auto => Ok(Self::Joint),
            chosen => Ok(chosen),
        }
    }
}

/// An evidence with its gradient.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Logarithm of the evidence.
    pub value: f64,
    /// Its derivatives in the parameters, each on the scale that it is adjusted on.
    pub gradient: Vec<f64>,
    /// Relative jitter that the factorisation needed.
    pub jitter: f64,
}

/// Jitter relative to each prior variance: first tried, and largest.
const FIRST_JITTER: f64 = 1e-10;
const LAST_JITTER: f64 = 1e-4;

/// Observations from which on work is shared between threads.
const PARALLEL_FROM: usize = 256;
/// Columns are shared out in this many lots, whatever the number of threads, so that sums do not
/// depend on it.
const LOTS: usize = 32;

/// A lower triangular matrix, stored column by column; what is above the diagonal means nothing.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    entries: Vec<f64>,
    size: usize,
}

impl Factor {
    pub fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.entries, self.size, self.size)
    }

    /// Rows at and below the diagonal of a column.
    fn column(&self, column: usize) -> &[f64] {
        &self.entries[column * self.size + column..(column + 1) * self.size]
    }

    /// x ← L⁻¹ x.
    pub fn forward(&self, x: &mut [f64]) {
        for column in 0..x.len() {
            let (pivot, below) = self.column(column).split_first().expect("a diagonal entry");
            let (value, rest) = x[column..].split_first_mut().expect("a column of x");
            *value /= pivot;
            rest.iter_mut().zip(below).for_each(|(x, l)| *x -= *value * l);
        }
    }

    /// x ← L⁻ᵀ x, for the leading rows of L as many as x has.
    pub fn backward(&self, x: &mut [f64]) {
        for column in (0..x.len()).rev() {
            let (pivot, below) = self.column(column).split_first().expect("a diagonal entry");
            let (value, rest) = x[column..].split_first_mut().expect("a column of x");
            *value = (*value - rest.iter().zip(below).map(|(x, l)| x * l).sum::<f64>()) / pivot;
        }
    }
}

/// A factored covariance with the residuals.
#[derive(Debug)]
pub(crate) struct Factored {
    /// Its Cholesky factor.
    pub factor: Factor,
    /// y − mean.
    pub residual: Vec<f64>,
    /// L⁻¹ (y − mean).
    pub whitened: Vec<f64>,
    pub jitter: f64,
}

/// Coefficients of all groups at given parameters.
pub(crate) struct State<'a, const D: usize> {
    model: &'a Model<D>,
    /// Parameters of each part's kernel, and amplitudes.
    kernels: Vec<(f64, Vec<f64>)>,
    theta: Vec<f64>,
    /// For each part and group, a_β.
    coefficients: Vec<Vec<Vec<f64>>>,
    /// For each group, values of the monomials.
    monomials: Vec<Vec<f64>>,
    /// For each group, the standard deviation of its noise.
    noise: Vec<f64>,
}

/// a_β = amplitude · Σ_t μ_t A_{t,β}.
pub(crate) fn combine(amplitude: f64, monomials: &[f64], arrays: &[Vec<f64>]) -> Vec<f64> {
    let mut sum = vec![0.0; arrays.first().map_or(0, Vec::len)];
    for (monomial, array) in monomials.iter().zip(arrays) {
        let factor = amplitude * monomial;
        sum.iter_mut().zip(array).for_each(|(s, a)| *s += factor * a);
    }
    sum
}

impl<'a, const D: usize> State<'a, D> {
    pub fn new(model: &'a Model<D>, scaled: &[f64]) -> Result<Self, GpError> {
        let (found, expected) = (scaled.len(), model.parameters.len());
        if found != expected {
            return Err(GpError::ParameterCount { found, expected });
        }
        let theta = model.theta_values(scaled);
        let kernels: Vec<(f64, Vec<f64>)> = model
            .part_offsets
            .iter()
            .enumerate()
            .map(|(part, offset)| {
                let count = model.prior.parts[part].kernel.hyperparameters().len();
                let hyperparameters = &scaled[offset + 1..offset + 1 + count];
                (scaled[*offset].exp(), hyperparameters.iter().map(|h| h.exp()).collect())
            })
            .collect();
        let monomials: Vec<Vec<f64>> = model
            .groups
            .iter()
            .map(|g| g.points.monomials.iter().map(|m| monomial_value(m, &theta)).collect())
            .collect();
        let coefficients = kernels
            .iter()
            .enumerate()
            .map(|(part, (amplitude, _))| {
                let groups = model.groups.iter().zip(&monomials);
                groups
                    .map(|(g, monomials)| {
                        combine(*amplitude, monomials, &g.points.parts[part].arrays)
                    })
                    .collect()
            })
            .collect();
        let noise = model
            .groups
            .iter()
            .map(|group| match group.variance {
                Variance::Known(sigma) => sigma,
                Variance::Learned(position) => scaled[position].exp(),
            })
            .collect();
        Ok(Self { model, kernels, theta, coefficients, monomials, noise })
    }

    pub fn noise(&self, group: usize) -> f64 {
        self.noise[group]
    }

    pub fn theta(&self) -> &[f64] {
        &self.theta
    }

    pub fn kernel(&self, part: usize) -> (f64, &[f64]) {
        let (amplitude, hyperparameters) = &self.kernels[part];
        (*amplitude, hyperparameters)
    }

    pub fn side(&self, part: usize, group: usize) -> Side<'_, D> {
        Side {
            points: &self.model.groups[group].points,
            coefficients: &self.coefficients[part][group],
        }
    }

    fn block(&self, part: usize, first: usize, second: usize) -> Block<'_, D> {
        Block {
            kernel: &*self.model.prior.parts[part].kernel,
            hyperparameters: &self.kernels[part].1,
            plan: &self.model.plans[part][first * self.model.groups.len() + second],
            first: self.side(part, first),
            second: self.side(part, second),
        }
    }

    fn residual(&self) -> Vec<f64> {
        let mut residual = Vec::with_capacity(self.model.size);
        for (group, monomials) in self.model.groups.iter().zip(&self.monomials) {
            let start = residual.len();
            residual.extend_from_slice(&group.values);
            for (monomial, mean) in monomials.iter().zip(&group.points.mean) {
                let rows = residual[start..].iter_mut().zip(mean);
                rows.for_each(|(r, m)| *r -= monomial * m);
            }
        }
        residual
    }

    /// The lower triangle of the covariance of the functionals without noise, column by column.
    fn covariance(&self) -> Vec<f64> {
        let size = self.model.size;
        let mut matrix = vec![0.0; size * size];
        let column = |(number, column): (usize, &mut [f64]), scratch: &mut Scratch| {
            let second = self.group_of(number);
            for part in 0..self.kernels.len() {
                for first in second..self.model.groups.len() {
                    let (start, rows) = self.rows(first, number);
                    self.block(part, first, second).add_column(
                        start,
                        number - self.model.groups[second].offset,
                        &mut column[rows],
                        scratch,
                    );
                }
            }
        };
        if self.parallel() {
            matrix
                .par_chunks_mut(size)
                .enumerate()
                .for_each_init(Scratch::default, |scratch, numbered| column(numbered, scratch));
        } else {
            let mut scratch = Scratch::default();
            matrix.chunks_mut(size).enumerate().for_each(|numbered| column(numbered, &mut scratch));
        }
        matrix
    }

    fn parallel(&self) -> bool {
        self.model.size >= PARALLEL_FROM && rayon::current_num_threads() > 1
    }

    fn threads(&self) -> Par {
        if self.parallel() { Par::rayon(0) } else { Par::Seq }
    }

    fn group_of(&self, row: usize) -> usize {
        self.model
            .groups
            .iter()
            .rposition(|group| group.offset <= row && !group.values.is_empty())
            .expect("every row belongs to a group")
    }

    /// Rows of `group` at or below the diagonal of `column`: first point, and range in the matrix.
    fn rows(&self, group: usize, column: usize) -> (usize, std::ops::Range<usize>) {
        let group = &self.model.groups[group];
        let start = column.saturating_sub(group.offset);
        (start, group.offset + start..group.offset + group.values.len())
    }

    /// Adds noise and jitter to the diagonal and factorises, with more jitter where needed.
    pub fn factored(&self) -> Result<Factored, GpError> {
        let size = self.model.size;
        let mut jitter = FIRST_JITTER;
        let mut matrix = self.covariance();
        loop {
            for (group, sigma) in self.model.groups.iter().zip(&self.noise) {
                for row in group.offset..group.offset + group.values.len() {
                    let diagonal = &mut matrix[row * (size + 1)];
                    *diagonal = *diagonal * (1.0 + jitter) + sigma * sigma;
                }
            }
            if factorise(&mut matrix, size, self.threads()) {
                break;
            }
            jitter *= 10.0;
            if jitter > LAST_JITTER * 1.5 {
                return Err(GpError::NotPositiveDefinite { size, jitter: LAST_JITTER });
            }
            matrix = self.covariance();
        }
        let factor = Factor { entries: matrix, size };
        let residual = self.residual();
        let mut whitened = residual.clone();
        factor.forward(&mut whitened);
        Ok(Factored { factor, residual, whitened, jitter })
    }

    /// Rows whose probability the evidence is; those before are conditioned on.
    fn first_row(&self) -> usize {
        if self.model.evidence == Evidence::Conditional { self.model.imposed } else { 0 }
    }

    fn value(&self, factored: &Factored) -> f64 {
        let rows = self.first_row()..self.model.size;
        let count = rows.len() as f64;
        let sum: f64 = rows
            .map(|row| 0.5 * factored.whitened[row].powi(2) + factored.factor.column(row)[0].ln())
            .sum();
        -sum - 0.5 * count * (2.0 * PI).ln()
    }

    /// Cotangents of −ln evidence: of the covariance (lower triangle, as if its entries were
    /// independent and each off-diagonal one counted twice) and of the residual.
    ///
    /// With W the rows from `split` on of L⁻¹, z = L⁻¹ r, w = Wᵀ z_u and a = L_ff⁻ᵀ z_f, they are
    /// ½(WᵀW − wwᵀ − waᵀ − awᵀ) and w.
    fn cotangents(&self, factored: &Factored) -> (Mat<f64>, Vec<f64>) {
        let (size, split, par) = (self.model.size, self.first_row(), self.threads());
        let rest = size - split;
        let lower = factored.factor.view();
        let mut inverse = Mat::<f64>::zeros(rest, rest);
        let trailing = lower.submatrix(split, split, rest, rest);
        invert_lower(inverse.as_mut(), trailing, par);
        // W = [left | inverse] with left = −L_uu⁻¹ L_uf L_ff⁻¹.
        let mut left = Mat::<f64>::zeros(rest, split);
        if split > 0 {
            let below = lower.submatrix(split, 0, rest, split);
            matmul(
                left.as_mut(),
                BlockStructure::Rectangular,
                Accum::Replace,
                inverse.as_ref(),
                BlockStructure::TriangularLower,
                below,
                BlockStructure::Rectangular,
                -1.0,
                par,
            );
            let leading = lower.submatrix(0, 0, split, split);
            solve_upper_triangular_in_place(
                leading.transpose(),
                left.as_mut().transpose_mut(),
                par,
            );
        }
        let mut cotangent = Mat::<f64>::zeros(size, size);
        let (left, inverse) = (left.as_ref(), inverse.as_ref());
        let full = BlockStructure::Rectangular;
        let (low, high) = (BlockStructure::TriangularLower, BlockStructure::TriangularUpper);
        if split > 0 {
            let corner = cotangent.as_mut().submatrix_mut(0, 0, split, split);
            matmul(corner, low, Accum::Replace, left.transpose(), full, left, full, 1.0, par);
            let below = cotangent.as_mut().submatrix_mut(split, 0, rest, split);
            matmul(below, full, Accum::Replace, inverse.transpose(), high, left, full, 1.0, par);
        }
        let corner = cotangent.as_mut().submatrix_mut(split, split, rest, rest);
        matmul(corner, low, Accum::Replace, inverse.transpose(), high, inverse, low, 1.0, par);

        let (head, tail) = factored.whitened.split_at(split);
        let mut w = vec![0.0; size];
        for column in 0..size {
            w[column] = match column.checked_sub(split) {
                None => left.col(column).iter().zip(tail).map(|(l, z)| l * z).sum(),
                Some(c) => inverse.col(c).iter().zip(tail).skip(c).map(|(l, z)| l * z).sum(),
            };
        }
        let mut a = vec![0.0; size];
        a[..split].copy_from_slice(head);
        factored.factor.backward(&mut a[..split]);
        for column in 0..size {
            let (w_column, a_column) = (w[column], a[column]);
            let rows = cotangent.col_as_slice_mut(column);
            for row in column..size {
                rows[row] -= w[row] * (w_column + a_column) + a[row] * w_column;
            }
            // Half of it on the diagonal, twice the half for the pair off it.
            rows[column] *= 0.5;
        }
        (cotangent, w)
    }

    fn gradient(&self, factored: &Factored) -> Vec<f64> {
        let (mut cotangent, w) = self.cotangents(factored);
        let mut gradient = vec![0.0; self.model.parameters.len()];
        for (number, group) in self.model.groups.iter().enumerate() {
            let mut trace = 0.0;
            for row in group.offset..group.offset + group.values.len() {
                trace += cotangent[(row, row)];
                cotangent[(row, row)] *= 1.0 + factored.jitter;
            }
            if let Variance::Learned(position) = group.variance {
                gradient[position] += 2.0 * self.noise[number].powi(2) * trace;
            }
        }
        let mut pulled = self.pull_back(&cotangent);
        let mut theta = vec![0.0; self.theta.len()];
        for (number, group) in self.model.groups.iter().enumerate() {
            let mut slopes = vec![0.0; group.points.monomials.len()];
            for part in 0..self.kernels.len() {
                let slot = &mut pulled.coefficients[part][number];
                let amplitude = self.kernels[part].0;
                let own: f64 =
                    slot.iter().zip(&self.coefficients[part][number]).map(|(s, a)| s * a).sum();
                gradient[self.model.part_offsets[part]] += own;
                for (slope, array) in slopes.iter_mut().zip(&group.points.parts[part].arrays) {
                    *slope += amplitude * slot.iter().zip(array).map(|(s, a)| s * a).sum::<f64>();
                }
            }
            let rows = &w[group.offset..group.offset + group.values.len()];
            for (slope, mean) in slopes.iter_mut().zip(&group.points.mean) {
                *slope -= rows.iter().zip(mean).map(|(w, m)| w * m).sum::<f64>();
            }
            for (slope, monomial) in slopes.iter().zip(&group.points.monomials) {
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
        gradient.iter_mut().for_each(|g| *g = -*g);
        gradient
    }

    fn pull_back(&self, cotangent: &Mat<f64>) -> Pulled {
        let size = self.model.size;
        let lots = if self.parallel() { LOTS } else { 1 };
        let lot = |lot: usize| {
            let mut pulled = Pulled::zeros(self);
            let mut scratch = Scratch::default();
            // Interleaved, because early columns are longer.
            for column in (lot..size).step_by(lots) {
                self.pull_column(column, cotangent.col_as_slice(column), &mut pulled, &mut scratch);
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
                let block = self.block(part, first, second);
                let orders = self.model.groups[second].points.parts[part].orders.len();
                // The cotangents of the column's own point come back apart, for it may lie in the same group as the rows.
                pulled.own.clear();
                pulled.own.resize(orders, 0.0);
                let mut cotangents = Cotangents {
                    first: &mut pulled.coefficients[part][first],
                    second: &mut pulled.own,
                    hyperparameters: &mut pulled.hyperparameters[part],
                };
                block.pull_column(start, own, &weights[rows], &mut cotangents, scratch);
                let count = self.model.groups[second].points.count;
                let slots = pulled.coefficients[part][second].iter_mut().skip(own).step_by(count);
                slots.zip(&pulled.own).for_each(|(slot, value)| *slot += value);
            }
        }
    }
}

/// Cotangents of coefficients and kernel parameters.
struct Pulled {
    coefficients: Vec<Vec<Vec<f64>>>,
    hyperparameters: Vec<Vec<f64>>,
    own: Vec<f64>,
}

impl Pulled {
    fn zeros<const D: usize>(state: &State<'_, D>) -> Self {
        let zeros = |v: &Vec<f64>| vec![0.0; v.len()];
        Self {
            coefficients: state
                .coefficients
                .iter()
                .map(|groups| groups.iter().map(zeros).collect())
                .collect(),
            hyperparameters: state.kernels.iter().map(|(_, h)| zeros(h)).collect(),
            own: Vec::new(),
        }
    }

    fn add(&mut self, other: &Self) {
        let add = |to: &mut Vec<f64>, from: &Vec<f64>| {
            to.iter_mut().zip(from).for_each(|(t, f)| *t += f);
        };
        for (to, from) in self.coefficients.iter_mut().zip(&other.coefficients) {
            to.iter_mut().zip(from).for_each(|(t, f)| add(t, f));
        }
        for (to, from) in self.hyperparameters.iter_mut().zip(&other.hyperparameters) {
            add(to, from);
        }
    }
}

fn factorise(matrix: &mut [f64], size: usize, par: Par) -> bool {
    if matrix.iter().any(|entry| !entry.is_finite()) {
        return false;
    }
    let mut memory =
        MemBuffer::new(cholesky_in_place_scratch::<f64>(size, par, Default::default()));
    cholesky_in_place(
        MatMut::from_column_major_slice_mut(matrix, size, size),
        LltRegularization::default(),
        par,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .is_ok()
}

impl<const D: usize> Model<D> {
    /// The prior covariance of all observed functionals, without noise, row by row: imposed
    /// groups (equation, pseudo-observations) first, then the measured ones in their order.
    ///
    /// # Errors
    /// If the number of parameters is wrong.
    pub fn prior_covariance(&self, parameters: &[f64]) -> Result<Vec<Vec<f64>>, GpError> {
        let lower = State::new(self, parameters)?.covariance();
        let entry =
            |row: usize, column: usize| lower[row.min(column) * self.size + row.max(column)];
        Ok((0..self.size).map(|row| (0..self.size).map(|c| entry(row, c)).collect()).collect())
    }

    /// Logarithm of the evidence at parameters on their scales (see [`crate::FreeParameter`]).
    ///
    /// # Errors
    /// If their number is wrong, or the covariance is not positive definite with any jitter.
    pub fn log_evidence(&self, parameters: &[f64]) -> Result<f64, GpError> {
        let state = State::new(self, parameters)?;
        Ok(state.value(&state.factored()?))
    }

    /// [`Model::log_evidence`] with its gradient.
    ///
    /// # Errors
    /// As [`Model::log_evidence`].
    pub fn evaluate(&self, parameters: &[f64]) -> Result<Evaluation, GpError> {
        let state = State::new(self, parameters)?;
        let factored = state.factored()?;
        Ok(Evaluation {
            value: state.value(&factored),
            gradient: state.gradient(&factored),
            jitter: factored.jitter,
        })
    }
}
