//! Data-driven training.

use burn::tensor::Tensor;

use super::{Batch, Objective, SQUARED_NORM_FLOOR, require_displacements, simulated};
use crate::data::DataSet;
use crate::error::Result;
use sinew_emulate::coordinates::require_positive;

/// Mean nodal distance between simulated and predicted displacement, `mean ‖u − û‖₂`
/// (thesis, Equation 3.11), in units of a characteristic length.
#[doc(alias = "supervised")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataFit {
    length: f64,
}

impl DataFit {
    /// `length` makes distances dimensionless, usually
    /// [`OutputScale::length`](sinew_emulate::coordinates::OutputScale::length) \[length\].
    ///
    /// # Errors
    /// A length that is not positive.
    pub fn new(length: f64) -> Result<Self> {
        require_positive("the characteristic length of the displacements", length)?;
        Ok(Self { length })
    }

    /// The characteristic length \[length\].
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    /// Difference of prediction and simulation in units of the length, `[batch, nodes, D]`.
    pub(super) fn difference(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> Tensor<3> {
        let simulated = simulated(batch, displacement.dims(), &displacement.device());
        (displacement - simulated) / self.length
    }

    /// Mean length of the rows of `difference`.
    pub(super) fn mean_distance(difference: Tensor<3>) -> Tensor<1> {
        ((difference.clone() * difference).sum_dim(2) + SQUARED_NORM_FLOOR).sqrt().mean()
    }
}

impl Objective for DataFit {
    fn check(&self, data: &DataSet) -> Result<()> {
        require_displacements(data)
    }

    fn loss(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> Result<Tensor<1>> {
        Ok(Self::mean_distance(self.difference(batch, displacement)))
    }
}
