//! A density with its gradient, and its normal approximation at a mode.

use crate::error::SampleError;
use crate::standard_normals;
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::Rng;

/// Step of the differences of gradients, in units of the parameters: rounding leaves about ten digits.
const STEP: f64 = 1e-5;

/// Normal approximation: a mode and the covariance there, by its Cholesky factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Laplace {
    mode: DVector<f64>,
    /// Lower factor L of the covariance L Lᵀ.
    factor: DMatrix<f64>,
}

impl Laplace {
    /// Approximation with a precision, the negative second derivatives of the log density at the mode.
    ///
    /// # Errors
    /// A precision that is not positive definite.
    pub fn from_precision(mode: &[f64], precision: DMatrix<f64>) -> Result<Self, SampleError> {
        let seen = format!("{} parameters, largest entry {:.1e}", mode.len(), precision.amax());
        let covariance = Cholesky::new(precision).map(|factor| factor.inverse());
        Self::from_covariance(mode, covariance.ok_or_else(|| SampleError::curvature(&seen))?)
    }

    /// Approximation with a covariance.
    ///
    /// # Errors
    /// A covariance that is not positive definite.
    pub fn from_covariance(mode: &[f64], covariance: DMatrix<f64>) -> Result<Self, SampleError> {
        let seen = format!("{} parameters, largest entry {:.1e}", mode.len(), covariance.amax());
        let factor = Cholesky::new(covariance).ok_or_else(|| SampleError::curvature(&seen))?;
        Ok(Self { mode: DVector::from_column_slice(mode), factor: factor.unpack() })
    }

    /// Approximation at a mode, with second derivatives by central differences of the gradient.
    ///
    /// # Errors
    /// A density that is not finite about the mode, or has no maximum there.
    pub fn at(density: &impl LogDensity, mode: &[f64]) -> Result<Self, SampleError> {
        let count = density.dimension();
        let gradient = |at: usize, step: f64| {
            let (mut x, mut gradient) = (mode.to_vec(), vec![0.0; count]);
            x[at] += step;
            let value = density.value_and_gradient(&x, &mut gradient);
            value.is_finite().then_some(gradient)
        };
        let mut precision = DMatrix::zeros(count, count);
        for at in 0..count {
            let (Some(more), Some(less)) = (gradient(at, STEP), gradient(at, -STEP)) else {
                let reason = format!("the density is not finite beside parameter {at}");
                return Err(SampleError::curvature(&reason));
            };
            for other in 0..count {
                precision[(other, at)] = (less[other] - more[other]) / (2.0 * STEP);
            }
        }
        Self::from_precision(mode, 0.5 * (&precision + precision.transpose()))
    }

    /// Number of parameters.
    pub fn dimension(&self) -> usize {
        self.mode.len()
    }

    /// The mode.
    pub fn mode(&self) -> &[f64] {
        self.mode.as_slice()
    }

    /// The covariance.
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.factor * self.factor.transpose()
    }

    /// Laplace approximation of the same covariance at another mode.
    pub fn moved_to(&self, mode: &[f64]) -> Self {
        Self { mode: DVector::from_column_slice(mode), ..self.clone() }
    }

    /// The point of whitened coordinates z: mode + L z.
    pub fn point(&self, z: &[f64]) -> Vec<f64> {
        let moved = &self.mode + &self.factor * DVector::from_column_slice(z);
        moved.as_slice().to_vec()
    }

    /// Gradient in z of a function with a gradient in x: Lᵀ g.
    pub(crate) fn pull_back(&self, gradient: &[f64]) -> Vec<f64> {
        self.factor.tr_mul(&DVector::from_column_slice(gradient)).as_slice().to_vec()
    }

    /// Draws, with the standard deviations times `inflation`.
    pub fn draws(&self, count: usize, inflation: f64, random: &mut impl Rng) -> Vec<Vec<f64>> {
        let draw = |_| {
            let z = standard_normals(self.dimension(), random);
            self.point(&z.iter().map(|z| inflation * z).collect::<Vec<_>>())
        };
        (0..count).map(draw).collect()
    }
}

/// Logarithm of a density over ℝⁿ, up to a constant, with its gradient.
pub trait LogDensity: Sync {
    /// Number of parameters n.
    fn dimension(&self) -> usize;

    /// Logarithm at `x`, −∞ outside the domain; `gradient` is written where it is finite.
    fn value_and_gradient(&self, x: &[f64], gradient: &mut [f64]) -> f64;
}
