//! A model at given parameters: its covariance, factored.

use crate::evidence::factor::{Factor, for_columns};
use crate::evidence::gram::{Block, Leg, Scratch};
use crate::model::compile::Compiled;
use crate::prior::Part;
use crate::{Evaluation, Evidence, GpError, Model, Noise, Result};
use faer::Par;
use sinew_num::on_ready_threads;
use std::f64::consts::PI;

/// Jitter relative to each prior variance: first tried, and largest.
pub(crate) const FIRST_JITTER: f64 = 1e-10;
const LAST_JITTER: f64 = 1e-4;
/// Jitter of observations with noise in units of that of exact ones, in place of less noise: values far larger than their errors
/// keep these, and a few hundred rounding errors of their prior variance are covered.
const NOISY: f64 = 1e-2;

/// Observations from which on work is shared between threads.
const PARALLEL_FROM: usize = 256;

/// An evidence with or without its gradient.
type Computed<const D: usize> = fn(&Model<D>, &[f64], bool) -> Result<Evaluation>;

/// A factored covariance with the whitened residual.
pub(crate) struct Factored {
    /// Cholesky factor of the covariance.
    pub factor: Factor,
    /// L⁻¹ (y − mean).
    pub whitened: Vec<f64>,
    pub jitter: f64,
    /// Share of its prior variance that each observation has for its noise; 0 where that is its own.
    pub shares: Vec<f64>,
}

impl Factored {
    /// Logarithm of the probability of some rows, given those before.
    fn log_density(&self, rows: std::ops::Range<usize>) -> f64 {
        let count = rows.len() as f64;
        let row = |row: usize| 0.5 * self.whitened[row].powi(2) + self.factor.column(row)[0].ln();
        -rows.map(row).sum::<f64>() - 0.5 * count * (2.0 * PI).ln()
    }
}

/// Coefficients of all groups at given parameters.
pub(crate) struct State<'a, const D: usize> {
    pub model: &'a Model<D>,
    /// Amplitude of each part, and parameters of its kernel.
    pub kernels: Vec<(f64, Vec<f64>)>,
    /// The operators' parameters.
    pub theta: Vec<f64>,
    /// Legs of all groups.
    pub legs: Vec<Leg<'a, D>>,
    /// Standard deviation of the noise of each group.
    pub noise: Vec<f64>,
    /// Divisors of the variance of each observation's noise, by group.
    pub weights: Vec<Vec<f64>>,
}

impl<'a, const D: usize> State<'a, D> {
    pub(crate) fn new(model: &'a Model<D>, scaled: &[f64]) -> Result<Self> {
        model.check_count(scaled)?;
        let theta = model.theta_values(scaled);
        let of = |(part, offset): (&Part<D>, &usize)| {
            let count = part.kernel.hyperparameters().len();
            let hyperparameters = scaled[offset + 1..][..count].iter().map(|h| h.exp());
            (scaled[*offset].exp(), hyperparameters.collect())
        };
        let parts = model.prior.parts.iter().zip(&model.part_offsets);
        let kernels: Vec<(f64, Vec<f64>)> = parts.map(of).collect();
        let mut legs = Vec::new();
        for (group, own) in model.groups.iter().enumerate() {
            legs.extend(own.legs.iter().map(|points| {
                let coefficients = points.combined(&kernels, &theta);
                Leg { group, points, coefficients }
            }));
        }
        let sigma = |group: &Compiled<D>| match (group.given.noise, group.learned) {
            (_, Some(position)) => scaled[position].exp(),
            (Noise::Known(sigma), None) => sigma,
            _ => 0.0,
        };
        let noise = model.groups.iter().map(sigma).collect();
        let weights = model.groups.iter().map(|group| group.weights(scaled)).collect();
        Ok(Self { model, kernels, theta, legs, noise, weights })
    }

    /// Legs of a group.
    pub(crate) fn legs_of(&self, group: usize) -> std::ops::Range<usize> {
        let group = &self.model.groups[group];
        group.first_leg..group.first_leg + group.legs.len()
    }

    /// Covariance of one part between two legs.
    pub(crate) fn block(&self, part: usize, first: usize, second: usize) -> Block<'_, D> {
        let plan = &self.model.plans[part][first * self.legs.len() + second];
        let [first, second] = [first, second].map(|leg| &self.legs[leg]);
        let kernel = &self.model.prior.parts[part].kernel;
        Block { kernel, hyperparameters: &self.kernels[part].1, plan, part, first, second }
    }

    /// Adds the covariances of a group's observations, from number `start` on, with that of a row of the matrix.
    pub(crate) fn add_covariances(
        &self,
        [group, start]: [usize; 2],
        row: usize,
        out: &mut [f64],
        scratch: &mut Scratch,
    ) {
        let own = self.group_of(row);
        let point = row - self.model.groups[own].offset;
        for part in 0..self.kernels.len() {
            for first in self.legs_of(group) {
                for second in self.legs_of(own) {
                    self.block(part, first, second).add_column(start, point, out, scratch);
                }
            }
        }
    }

    /// y − mean.
    pub(crate) fn residual(&self) -> Vec<f64> {
        let mut residual = Vec::with_capacity(self.model.size);
        for group in &self.model.groups {
            let start = residual.len();
            residual.extend_from_slice(&group.given.values);
            for leg in &group.legs {
                leg.subtract_mean(&self.theta, &mut residual[start..]);
            }
        }
        residual
    }

    /// The lower triangle of the covariance of the functionals without noise, column by column.
    pub(crate) fn covariance(&self) -> Vec<f64> {
        let size = self.model.size;
        let mut matrix = vec![0.0; size * size];
        let column = |(number, column): (usize, &mut [f64]), scratch: &mut Scratch| {
            for group in self.group_of(number)..self.model.groups.len() {
                let (start, rows) = self.rows(group, number);
                self.add_covariances([group, start], number, &mut column[rows], scratch);
            }
        };
        for_columns(self.threads(), (&mut matrix, size), column);
        matrix
    }

    /// Whether there is work enough to share out.
    pub(crate) fn is_large(&self) -> bool {
        self.model.size >= PARALLEL_FROM
    }

    pub(crate) fn threads(&self) -> Par {
        let shared = self.is_large() && rayon::current_num_threads() > 1;
        if shared { Par::rayon(0) } else { Par::Seq }
    }

    pub(crate) fn group_of(&self, row: usize) -> usize {
        let mut groups = self.model.groups.iter();
        groups.position(|group| group.rows().contains(&row)).expect("every row belongs to a group")
    }

    /// Rows of `group` at or below the diagonal of `column`: first point, and range in the matrix.
    pub(crate) fn rows(&self, group: usize, column: usize) -> (usize, std::ops::Range<usize>) {
        let group = &self.model.groups[group];
        let start = column.saturating_sub(group.offset);
        (start, group.offset + start..group.offset + group.given.values.len())
    }

    /// Adds noise and jitter to the diagonal and factorises, with more jitter where needed.
    pub(crate) fn factored(&self) -> Result<Factored> {
        let size = self.model.size;
        let mut jitter = FIRST_JITTER;
        // Steps by factors of ten do not hit the last one exactly.
        while jitter <= LAST_JITTER * 2.0 {
            let (mut matrix, mut shares) = (self.covariance(), vec![0.0; size]);
            for ((row, sigma), share) in self.sigmas().enumerate().zip(&mut shares) {
                let diagonal = &mut matrix[row * (size + 1)];
                let (least, own) =
                    (if sigma > 0.0 { NOISY * jitter } else { jitter }, sigma * sigma);
                *share = if own < least * *diagonal { least } else { 0.0 };
                *diagonal += own.max(least * *diagonal);
            }
            if let Some(factor) = Factor::new(matrix, size, self.threads()) {
                let mut whitened = self.residual();
                factor.forward(&mut whitened);
                return Ok(Factored { factor, whitened, jitter, shares });
            }
            jitter *= 10.0;
        }
        Err(GpError::NotPositiveDefinite { size, jitter: LAST_JITTER })
    }

    /// Standard deviation of each observation's noise.
    pub(crate) fn sigmas(&self) -> impl Iterator<Item = f64> {
        let groups = self.noise.iter().zip(&self.weights);
        groups.flat_map(|(sigma, weights)| weights.iter().map(move |weight| sigma / weight.sqrt()))
    }

    /// The first row that counts in full. Those before are imposed, and count [`State::weight`].
    pub(crate) fn first_row(&self) -> usize {
        if self.model.evidence == Evidence::Joint { 0 } else { self.model.imposed }
    }

    /// Power that the probability of imposed rows is raised to: all of them count as one. It is 1 without them, as in a joint evidence.
    pub(crate) fn weight(&self) -> f64 {
        1.0 / self.first_row().max(1) as f64
    }

    /// Logarithm of the probability of all rows that count in full, given the others.
    pub(crate) fn in_full(&self, factored: &Factored) -> f64 {
        let groups = self.model.groups.iter().zip(&self.noise);
        let scatter: f64 = groups.map(|(group, sigma)| group.scatter(*sigma).0).sum();
        factored.log_density(self.first_row()..self.model.size) + scatter
    }
}

impl<const D: usize> Model<D> {
    /// The prior covariance of all observed functionals, without noise, row by row: imposed
    /// groups (equation, pseudo-observations) first, then the measured ones in their order.
    ///
    /// # Errors
    /// If the number of parameters is wrong.
    pub fn prior_covariance(&self, parameters: &[f64]) -> Result<Vec<Vec<f64>>> {
        let lower = State::new(self, parameters)?.covariance();
        let entry = |row: usize, c: usize| lower[row.min(c) * self.size + row.max(c)];
        Ok((0..self.size).map(|row| (0..self.size).map(|c| entry(row, c)).collect()).collect())
    }

    /// Logarithm of the evidence at parameters on their scales (see [`crate::FreeParameter`]).
    ///
    /// # Errors
    /// If their number is wrong, or the covariance is not positive definite with any jitter.
    pub fn log_evidence(&self, parameters: &[f64]) -> Result<f64> {
        Ok(instance!(D, Model::computed, Computed<D>)(self, parameters, false)?.value)
    }

    /// [`Model::log_evidence`] with its gradient.
    ///
    /// # Errors
    /// As [`Model::log_evidence`].
    pub fn evaluate(&self, parameters: &[f64]) -> Result<Evaluation> {
        instance!(D, Model::computed, Computed<D>)(self, parameters, true)
    }

    fn computed(&self, parameters: &[f64], with_gradient: bool) -> Result<Evaluation> {
        let state = State::new(self, parameters)?;
        let evaluate = || {
            let factored = state.factored()?;
            let imposed = state.weight() * factored.log_density(0..state.first_row());
            Ok(Evaluation {
                value: state.in_full(&factored) + imposed,
                gradient: if with_gradient { state.gradient(&factored) } else { Vec::new() },
                jitter: factored.jitter,
            })
        };
        // Values alone are asked for by many threads at once.
        let alone = !with_gradient || state.threads() == Par::Seq;
        if alone { evaluate() } else { on_ready_threads(evaluate) }
    }
}
