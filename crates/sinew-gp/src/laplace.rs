//! A normal approximation to the posterior of all parameters.

use faer::linalg::solvers::SelfAdjointEigen;
use faer::{Mat, Side as Triangle};
use rand::SeedableRng;
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
}

/// Step in the (mostly logarithmic) parameters of the difference of gradients.
const STEP: f64 = 1e-3;
/// Directions in which the logarithm of the density curves less than this are as good as flat:
/// their standard deviation is kept to about a factor e².
const LEAST_CURVATURE: f64 = 0.25;

impl Normal {
    /// From central differences of the gradient; parameters at their bounds stay there.
    pub fn at<const D: usize>(model: &Model<D>, mean: &[f64]) -> Result<Self, GpError> {
        let count = mean.len();
        let free: Vec<bool> = model
            .parameters()
            .iter()
            .zip(mean)
            .map(|(p, x)| {
                let [lower, upper] = p.bounds.map(|bound| p.to_scale(bound));
                x - STEP > lower && x + STEP < upper
            })
            .collect();
        let mut curvature = Mat::<f64>::zeros(count, count);
        for column in (0..count).filter(|column| free[*column]) {
            let gradient = |step: f64| {
                let mut moved = mean.to_vec();
                moved[column] += step;
                Ok::<_, GpError>(
                    model.evaluate_posterior(model.ensemble_evidence(), &moved)?.gradient,
                )
            };
            let (after, before) = (gradient(STEP)?, gradient(-STEP)?);
            for row in (0..count).filter(|row| free[*row]) {
                curvature[(row, column)] = -(after[row] - before[row]) / (2.0 * STEP);
            }
        }
        let symmetric =
            Mat::from_fn(count, count, |i, j| 0.5 * (curvature[(i, j)] + curvature[(j, i)]));
        let Ok(eigen) = SelfAdjointEigen::new(symmetric.as_ref(), Triangle::Lower) else {
            return Err(GpError::NotPositiveDefinite { size: count, jitter: 0.0 });
        };
        let (vectors, values) = (eigen.U(), eigen.S().column_vector());
        let factor = Mat::from_fn(count, count, |row, mode| {
            let spread = values[mode].max(LEAST_CURVATURE).sqrt().recip();
            if free[row] { vectors[(row, mode)] * spread } else { 0.0 }
        });
        Ok(Self { mean: mean.to_vec(), factor })
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
/// for the evidence of [`Model::ensemble_evidence`].
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
            for (x, p) in point.iter_mut().zip(model.parameters()) {
                *x = x.clamp(p.to_scale(p.bounds[0]), p.to_scale(p.bounds[1]));
            }
            point
        })
        .collect();
    Ok(Ensemble::new(model.clone(), draws))
}
