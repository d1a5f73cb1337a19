//! Objectives of training: data-driven and physics-informed training differ only here.

mod data_fit;
mod minimum_potential;

pub use data_fit::DataFit;
pub use minimum_potential::{MinimumPotential, Potential};

use crate::{DataSet, Result, Sample};
use burn::tensor::Tensor;

/// A loss of predicted displacements. [`Objective::check`] requires that it suits the data.
///
/// Samples of a batch are all of one geometry, and in the order of the predictions.
///
/// Losses are dimensionless, so that learning rates and gradient clipping mean the same in every
/// system of units.
pub trait Objective: Send + Sync {
    /// Requires that the data set holds what the objective reads.
    ///
    /// # Errors
    /// The first misfit.
    fn check(&self, data: &DataSet) -> Result<()>;

    /// Mean loss of a batch, differentiable with respect to `displacement`
    /// (`[batch, real nodes, D]` in units of length).
    ///
    /// # Errors
    /// A batch the objective cannot be evaluated on.
    fn loss(&self, samples: &[&Sample], displacement: Tensor<3>) -> Result<Tensor<1>>;

    /// Number of displacements of a batch that the objective finds inadmissible.
    fn inadmissible(&self, samples: &[&Sample], displacement: Tensor<3>) -> usize {
        let _ = (samples, displacement);
        0
    }
}

/// Added to squared norms, so that their root can be differentiated at zero. In units of the
/// squared characteristic size: distances below 1e-6 of it are rounded up.
const SQUARED_NORM_FLOOR: f32 = 1e-12;
