//! A normal approximation to the posterior of all parameters.

use std::f64::consts::PI;

use faer::linalg::solvers::SelfAdjointEigen;
use faer::{Mat, Side as Triangle};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::ensemble::Ensemble;
use crate::error::GpError;
use crate::fit::Fit;
use crate::model::Model;
use crate::posterior::standard_normal;

/// The normal distribution with the fit's parameters as mean and the curvature there.
pub(crate) struct Normal {
    pub mean: Vec<f64>,
    /// A factor S of the covariance S Sᵀ, one column for each direction.
    pub factor: Mat<f64>,
    /// Parameters at a bound, which are not normal: how far inside they are on average, with a sign.
    at_bounds: Vec<(usize, f64)>,
}

/// Step in the (mostly logarithmic) parameters of the difference of gradients; on short intervals a share of
/// half of them.
const STEP: f64 = 1e-3;
/// Directions in which the logarithm of the density curves less than this are as good as flat:
/// their standard deviation is kept to about a factor e².
const LEAST_CURVATURE: f64 = 0.25;

impl Normal {
    /// From central differences of the gradient. From a bound the density falls inwards as exp(−g t − ½ h t²): it is
    /// taken for an exponential one, of the mean that is right where g or h is zero, independent of the rest.
    pub fn at<const D: usize>(model: &Model<D>, mean: &[f64]) -> Result<Self, GpError> {
        let count = mean.len();
        let bounds = model.scaled_bounds();
        let step = |k: usize| STEP * (0.5 * (bounds[k][1] - bounds[k][0])).min(1.0);
        let inwards: Vec<Option<f64>> = (0..count)
            .map(|k| match mean[k] {
                x if x - step(k) <= bounds[k][0] => Some(1.0),
                x if x + step(k) >= bounds[k][1] => Some(-1.0),
                _ => None,
            })
            .collect();
        let free = |k: &usize| inwards[*k].is_none();
        let gradient = |column: usize, step: f64| {
            let mut moved = mean.to_vec();
            moved[column] += step;
            let evaluation = model.evaluate_posterior(model.ensemble_evidence(), &moved)?;
            Ok::<_, GpError>(evaluation.gradient)
        };
        let mut curvature = Mat::<f64>::zeros(count, count);
        let mut at_bounds = Vec::new();
        for (column, inwards) in inwards.iter().enumerate() {
            let step = step(column);
            let Some(sign) = inwards else {
                let (after, before) = (gradient(column, step)?, gradient(column, -step)?);
                for row in (0..count).filter(free) {
                    curvature[(row, column)] = -(after[row] - before[row]) / (2.0 * step);
                }
                continue;
            };
            let fall = |steps: f64| Ok(-sign * gradient(column, sign * steps * step)?[column]);
            let (here, further): (f64, f64) = (fall(0.0)?, fall(1.0)?);
            let bend = ((further - here) / step).max(LEAST_CURVATURE);
            at_bounds.push((column, sign / (here.max(0.0) + (0.5 * PI * bend).sqrt())));
        }
        let symmetric =
            Mat::from_fn(count, count, |i, j| 0.5 * (curvature[(i, j)] + curvature[(j, i)]));
        let Ok(eigen) = SelfAdjointEigen::new(symmetric.as_ref(), Triangle::Lower) else {
            return Err(GpError::NotPositiveDefinite { size: count, jitter: 0.0 });
        };
        let (vectors, values) = (eigen.U(), eigen.S().column_vector());
        let factor = Mat::from_fn(count, count, |row, mode| {
            let spread = values[mode].max(LEAST_CURVATURE).sqrt().recip();
            if free(&row) { vectors[(row, mode)] * spread } else { 0.0 }
        });
        Ok(Self { mean: mean.to_vec(), factor, at_bounds })
    }

    /// mean + S z.
    pub fn map(&self, z: &[f64]) -> Vec<f64> {
        let mut point = self.mean.clone();
        for (mode, z) in z.iter().enumerate() {
            point.iter_mut().zip(self.factor.col(mode).iter()).for_each(|(x, s)| *x += s * z);
        }
        point
    }
}

/// Draws parameters from the normal approximation at the fit (Laplace), kept within their bounds,
/// for the evidence of [`Model::ensemble_evidence`]. Parameters that the fit has at a bound are drawn from what
/// falls off inside of it.
///
/// # Errors
/// If the evidence cannot be evaluated next to the fit.
pub fn laplace<const D: usize>(
    fit: &Fit<D>,
    draws: usize,
    seed: u64,
) -> Result<Ensemble<D>, GpError> {
    let model = fit.model();
    let normal = Normal::at(model, &fit.ensemble_mode())?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let draws = (0..draws)
        .map(|_| {
            let z: Vec<f64> =
                (0..normal.mean.len()).map(|_| standard_normal(&mut random)).collect();
            let mut point = normal.map(&z);
            for (position, mean) in &normal.at_bounds {
                point[*position] -= mean * (1.0 - random.random::<f64>()).ln();
            }
            for (x, [lower, upper]) in point.iter_mut().zip(model.scaled_bounds()) {
                *x = x.clamp(lower, upper);
            }
            point
        })
        .collect();
    Ok(Ensemble::new(model.clone(), draws))
}
