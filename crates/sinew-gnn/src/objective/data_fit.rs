//! Data-driven training.

use burn::tensor::{Tensor, TensorData};

use super::{Batch, Objective, SQUARED_NORM_FLOOR};
use crate::data::DataSet;
use crate::error::Result;
use sinew_emulate::coordinates::{require_count, require_positive};

/// Mean nodal distance between simulated and predicted displacement, `mean ‖u − û‖₂`
/// (thesis, Equation 3.11), in units of a characteristic length.
#[doc(alias = "supervised")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataFit {
    /// The characteristic length \[length\].
    pub(super) length: f64,
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

    /// Difference of prediction and simulation in units of the length, `[batch, nodes, D]`.
    pub(super) fn difference(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> Tensor<3> {
        let values = batch.samples.iter().flat_map(|sample| &sample.displacement);
        let values: Vec<f32> = values.map(|&value| value as f32).collect();
        let values = TensorData::new(values, displacement.dims());
        let simulated = Tensor::from_data(values, &displacement.device());
        (displacement - simulated) / self.length
    }

    /// Mean length of the rows of `difference`.
    pub(super) fn mean_distance(difference: Tensor<3>) -> Tensor<1> {
        ((difference.clone() * difference).sum_dim(2) + SQUARED_NORM_FLOOR).sqrt().mean()
    }
}

impl Objective for DataFit {
    fn check(&self, data: &DataSet) -> Result<()> {
        data.training.iter().chain(&data.validation).try_for_each(|sample| {
            let geometry = data.geometries.get(sample.geometry);
            let degrees_of_freedom = geometry.map_or(0, |body| body.dirichlet.prescribed.len());
            require_count(
                "displacement values of a sample (data-driven training needs a simulation of each)",
                sample.displacement.len(),
                degrees_of_freedom,
            )?;
            Ok(())
        })
    }

    fn loss(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> Result<Tensor<1>> {
        Ok(Self::mean_distance(self.difference(batch, displacement)))
    }
}
