//! Data-driven training, on displacements.

use super::{Objective, SQUARED_NORM_FLOOR};
use crate::fused::mean_distance;
use crate::{DataSet, Result, Sample};
use burn::tensor::Tensor;
use sinew_emulate::coordinates::{require_count, require_positive};

/// Mean nodal distance between simulated and predicted displacement, `mean ‖u − û‖₂`
/// (thesis, Equation 3.11), in units of a characteristic length.
#[doc(alias = "supervised")]
#[derive(Debug, Clone, PartialEq)]
pub struct DataFit {
    /// The characteristic length \[length\].
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
}

impl Objective for DataFit {
    fn check(&self, data: &DataSet) -> Result<()> {
        data.training.iter().chain(&data.validation).try_for_each(|sample| {
            let geometry = data.geometries.get(sample.geometry);
            let expected = geometry.map_or(0, |body| body.dirichlet.prescribed.len());
            let what =
                "displacement values of a sample (data-driven training needs a simulation of each)";
            Ok(require_count(what, sample.displacement.len(), expected)?)
        })
    }

    fn loss(&self, samples: &[&Sample], displacement: Tensor<3>) -> Result<Tensor<1>> {
        let simulated = samples.iter().flat_map(|sample| &sample.displacement);
        let simulated: Vec<f32> = simulated.map(|&value| value as f32).collect();
        Ok(mean_distance(displacement, simulated, self.length as f32, SQUARED_NORM_FLOOR))
    }
}
