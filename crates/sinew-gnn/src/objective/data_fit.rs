//! Data-driven training.

use burn::tensor::Tensor;

use super::{Batch, Objective, SQUARED_NORM_FLOOR};
use crate::fused::mean_distance;
use crate::{DataSet, Result};
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

    /// Simulated displacements of a batch, sample by sample.
    pub(super) fn simulated(batch: &Batch<'_>) -> Vec<f32> {
        let values = batch.samples.iter().flat_map(|sample| &sample.displacement);
        values.map(|&value| value as f32).collect()
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
        let (unit, floor) = (self.length as f32, SQUARED_NORM_FLOOR as f32);
        Ok(mean_distance(displacement, Self::simulated(batch), unit, floor))
    }
}
