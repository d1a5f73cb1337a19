//! Posterior density over an emulator of stored runs, and its modes.

use crate::likelihood::Noise;
use crate::mode::distance;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sinew_emulate::{Emulated, RunsEmulator};
use sinew_sample::{LogDensity, standard_normals};
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

/// Draws of the prior that searches for a mode start from, at [`STARTS`] of them: the likeliest, then each time the likeliest that is
/// [`SPREAD`] from those before \[prior standard deviations\]. The likeliest alone may all climb one mode.
const PRIOR_DRAWS: usize = 400;
const STARTS: usize = 16;
const SPREAD: f64 = 0.3;
/// Steps of a search, and the gain of the log density that ends it.
const STEPS: usize = 100;
const CONVERGED: f64 = 1e-6;
/// Logarithm of the mass of the best mode over that of a mode, by Laplace's method, above which the mode is dropped: it has less than 1 %.
const NEGLIGIBLE: f64 = 4.6;
/// Distance above which two modes are distinct \[posterior standard deviations\].
const APART: f64 = 3.0;

/// Posterior density of the parameters of stored runs over their emulator, in coordinates whose prior is standard normal: θ is
/// uniform over its range, or over the logarithm of it. The covariance of the emulator's errors is added to the variances of the data.
///
/// ```
/// use sinew_calibrate::Surrogate;
/// use sinew_emulate::{Output, RunsEmulator};
/// use sinew_energy::Parameter;
///
/// let thetas: Vec<Vec<f64>> = (0..20).map(|i| vec![1.0 + 0.1 * i as f64]).collect();
/// let values = thetas.iter().map(|theta| vec![40.0 + 5.0 / theta[0]]).collect();
/// let volume = Output { name: "volume".into(), unit: "ml".into(), values };
/// let stiffness = Parameter::log("k", "kPa", 1.0..=2.9);
/// let emulator = RunsEmulator::fit(vec![stiffness], &thetas, &[volume], None, &mut ())?;
/// let surrogate = Surrogate::new(&emulator, vec![(0, 42.5, 0.05)]);
/// let (mode, _) = &surrogate.modes(1)[0];
/// assert!((surrogate.theta(mode)[0] - 2.0).abs() < 0.02);
/// # Ok::<(), sinew_emulate::Error>(())
/// ```
pub struct Surrogate<'a> {
    emulator: &'a RunsEmulator,
    /// Places of the data among the outputs, values and standard deviations.
    places: Vec<usize>,
    values: DVector<f64>,
    variances: DVector<f64>,
    /// Correlation of the emulator's errors of the data.
    correlation: DMatrix<f64>,
    normal: Normal,
}

impl<'a> Surrogate<'a> {
    /// Density given data: place among the outputs of numbers, value and standard deviation \[unit of the output\].
    ///
    /// # Panics
    /// A place beyond the outputs; evaluations of an emulator of displacements.
    pub fn new(emulator: &'a RunsEmulator, data: Vec<(usize, f64, f64)>) -> Self {
        let count = data.len();
        let places: Vec<usize> = data.iter().map(|datum| datum.0).collect();
        let correlation = |i: usize, j: usize| emulator.correlation(places[i], places[j]);
        let correlation = DMatrix::from_fn(count, count, correlation);
        let values = DVector::from_fn(count, |i, _| data[i].1);
        let variances = DVector::from_fn(count, |i, _| data[i].2.powi(2));
        Self { emulator, places, values, variances, correlation, normal: Normal::standard() }
    }

    /// Shares of the ranges of the parameters at coordinates.
    fn shares(&self, y: &[f64]) -> Vec<f64> {
        y.iter().map(|y| self.normal.cdf(*y)).collect()
    }

    /// Parameters at coordinates.
    pub fn theta(&self, y: &[f64]) -> Vec<f64> {
        let parameters = self.emulator.parameters.iter().zip(self.shares(y));
        parameters.map(|(parameter, share)| parameter.at_share(share)).collect()
    }

    /// Emulated outputs of the data at coordinates.
    pub fn at(&self, y: &[f64]) -> Vec<Emulated> {
        self.emulator.at_shares(&self.shares(y), &self.places)
    }

    /// Noise of the data, and the part of its covariance by the emulator's correlation R and deviations: R D.
    fn noise(&self, deviations: &[f64]) -> Option<(Noise, DMatrix<f64>)> {
        let mut shared = self.correlation.clone();
        (0..deviations.len()).for_each(|i| shared.column_mut(i).scale_mut(deviations[i]));
        let mut covariance = DMatrix::from_diagonal(&self.variances);
        for (i, deviation) in deviations.iter().enumerate() {
            for j in 0..deviations.len() {
                covariance[(i, j)] += deviation * shared[(i, j)];
            }
        }
        Some((Noise::of(covariance)?, shared))
    }

    /// Logarithm of the density, its gradient, and Gauss and Newton's precision.
    fn expand(&self, y: &[f64]) -> (f64, DVector<f64>, DMatrix<f64>) {
        let (count, data) = (y.len(), self.values.len());
        let slope: Vec<f64> = y.iter().map(|y| self.normal.pdf(*y)).collect();
        let prior = -DVector::from_column_slice(y);
        let found = self.at(y);
        let deviations: Vec<f64> = found.iter().map(|of| of.deviation).collect();
        let Some((noise, shared)) = self.noise(&deviations) else {
            return (f64::NEG_INFINITY, prior, DMatrix::identity(count, count));
        };
        let residual = DVector::from_fn(data, |i, _| self.values[i] - found[i].value);
        let (log_likelihood, weighted) = noise.log_likelihood(&residual);
        let inverse = noise.factor.inverse();
        // In the deviations δ: ½ αᵀ Σ' α − ½ tr(Σ⁻¹ Σ') with α = Σ⁻¹ r and Σ = S² + D R D.
        let pulled = &shared * &weighted;
        let by_deviation =
            |i: usize| weighted[i] * pulled[i] - shared.row(i).transpose().dot(&inverse.column(i));
        let by_deviation = DVector::from_fn(data, |i, _| by_deviation(i));
        let by_value = DMatrix::from_fn(data, count, |i, d| slope[d] * found[i].value_slopes[d]);
        let of_deviations =
            DMatrix::from_fn(data, count, |i, d| slope[d] * found[i].deviation_slopes[d]);
        let value = log_likelihood - 0.5 * prior.norm_squared();
        let gradient = prior + by_value.tr_mul(&weighted) + of_deviations.tr_mul(&by_deviation);
        let precision = DMatrix::identity(count, count) + by_value.tr_mul(&(inverse * &by_value));
        (value, gradient, precision)
    }

    /// Logarithm of the density of each datum at outputs, each before its deviation, given the parameters and the other data. Last,
    /// that of the likelihood by an emulator without errors over that with them, but for a constant.
    pub fn log_likelihoods(&self, outputs: &[f64]) -> Vec<f64> {
        let (pairs, _) = outputs.as_chunks::<2>();
        let deviations: Vec<f64> = pairs.iter().map(|[_, deviation]| *deviation).collect();
        let Some((noise, _)) = self.noise(&deviations) else {
            return vec![f64::NEG_INFINITY; pairs.len() + 1];
        };
        let residual = DVector::from_fn(pairs.len(), |i, _| self.values[i] - pairs[i][0]);
        let exact: f64 = residual.iter().zip(&self.variances).map(|(r, of)| r * r / of).sum();
        let weight = -noise.log_likelihood(&residual).0 - 0.5 * exact;
        noise.one_by_one(&residual).into_iter().chain([weight]).collect()
    }

    /// Distinct modes with their precisions, the best first; none where the density is nowhere finite.
    pub fn modes(&self, seed: u64) -> Vec<(Vec<f64>, DMatrix<f64>)> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let count = self.emulator.parameters.len();
        let draw = |_| DVector::from_vec(standard_normals(count, &mut random));
        let mut starts: Vec<_> =
            (0..PRIOR_DRAWS).map(draw).map(|y| (self.expand(y.as_slice()).0, y)).collect();
        starts.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut apart: Vec<DVector<f64>> = Vec::new();
        for (_, y) in starts {
            if apart.len() < STARTS && apart.iter().all(|other| (other - &y).norm() > SPREAD) {
                apart.push(y);
            }
        }
        let mut found: Vec<_> = apart.into_iter().filter_map(|y| self.climb(y)).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let best = found.first().map_or(0.0, |mode| mode.0);
        let mut modes: Vec<(Vec<f64>, DMatrix<f64>)> = Vec::new();
        for (_, y, precision) in found.into_iter().take_while(|mode| best - mode.0 < NEGLIGIBLE) {
            let y = y.as_slice().to_vec();
            if modes.iter().all(|(other, precision)| distance(&y, other, precision) > APART) {
                modes.push((y, precision));
            }
        }
        modes
    }

    /// A maximum with the logarithm of its mass and its precision, by Levenberg's and Marquardt's method (Nocedal and Wright, 10.3).
    fn climb(&self, mut y: DVector<f64>) -> Option<(f64, DVector<f64>, DMatrix<f64>)> {
        let (mut value, mut gradient, mut precision) = self.expand(y.as_slice());
        let mut damping = 1e-2;
        for _ in 0..STEPS {
            let mut damped = precision.clone();
            (0..y.len()).for_each(|at| damped[(at, at)] *= 1.0 + damping);
            let next = &y + Cholesky::new(damped)?.solve(&gradient);
            let found = self.expand(next.as_slice());
            let gain = found.0 - value;
            if gain > 0.0 {
                (y, (value, gradient, precision)) = (next, found);
                damping *= 0.1;
            } else {
                damping *= 10.0;
            }
            if gain.abs() < CONVERGED {
                break;
            }
        }
        let factor = Cholesky::new(precision.clone()).filter(|_| value.is_finite())?;
        let half_log_determinant = factor.l_dirty().diagonal().map(f64::ln).sum();
        Some((value - half_log_determinant, y, precision))
    }
}

impl LogDensity for Surrogate<'_> {
    fn dimension(&self) -> usize {
        self.emulator.parameters.len()
    }

    fn value_and_gradient(&self, y: &[f64], gradient: &mut [f64]) -> f64 {
        let (value, slopes, _) = self.expand(y);
        gradient.copy_from_slice(slopes.as_slice());
        value
    }
}
