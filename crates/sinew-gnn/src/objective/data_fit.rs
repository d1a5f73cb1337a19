//! Data-driven training.

use burn::tensor::{Tensor, TensorData};

use super::{GradientOperator, Objective, SQUARED_NORM_FLOOR};
use crate::fused::mean_distance;
use crate::{DataSet, Result, Sample};
use sinew_emulate::coordinates::{require_count, require_positive};

/// Mean nodal distance between simulated and predicted displacement, `mean ‖u − û‖₂`
/// (thesis, Equation 3.11), in units of a characteristic length; with deformation gradients, which have no unit, `… + w mean ‖F − F̂‖_F`
/// (Equation B.1).
#[doc(alias = "supervised")]
#[derive(Debug, Clone, PartialEq)]
pub struct DataFit {
    /// The characteristic length \[length\].
    length: f64,
    /// Weight of the deformation gradients, with one operator per geometry.
    gradients: Option<(f64, Vec<GradientOperator>)>,
}

impl DataFit {
    /// `length` makes distances dimensionless, usually
    /// [`OutputScale::length`](sinew_emulate::coordinates::OutputScale::length) \[length\].
    ///
    /// # Errors
    /// A length that is not positive.
    pub fn new(length: f64) -> Result<Self> {
        require_positive("the characteristic length of the displacements", length)?;
        Ok(Self { length, gradients: None })
    }

    /// The objective with deformation gradients, by one operator per geometry.
    ///
    /// # Errors
    /// A weight that is not positive.
    pub fn with_gradients(self, weight: f64, operators: Vec<GradientOperator>) -> Result<Self> {
        require_positive("the weight of the deformation gradients", weight)?;
        Ok(Self { gradients: Some((weight, operators)), ..self })
    }
}

impl Objective for DataFit {
    fn check(&self, data: &DataSet) -> Result<()> {
        data.training.iter().chain(&data.validation).try_for_each(|sample| {
            let geometry = data.geometries.get(sample.geometry);
            let expected = geometry.map_or(0, |body| body.dirichlet.prescribed.len());
            let what =
                "displacement values of a sample (data-driven training needs a simulation of each)";
            require_count(what, sample.displacement.len(), expected)
        })?;
        let Some((_, operators)) = &self.gradients else { return Ok(()) };
        require_count("gradient operators", operators.len(), data.geometries.len())?;
        let mut all = operators.iter().zip(&data.geometries);
        all.try_for_each(|(operator, geometry)| operator.check(geometry))
    }

    fn loss(&self, samples: &[&Sample], displacement: Tensor<3>) -> Result<Tensor<1>> {
        let (unit, floor) = (self.length as f32, SQUARED_NORM_FLOOR as f32);
        let simulated = samples.iter().flat_map(|sample| &sample.displacement);
        let simulated: Vec<f32> = simulated.map(|&value| value as f32).collect();
        let Some((weight, operators)) = &self.gradients else {
            return Ok(mean_distance(displacement, simulated, unit, floor));
        };
        let field = TensorData::new(simulated.clone(), displacement.dims());
        let field = Tensor::from_data(field, &displacement.device());
        let difference = (displacement.clone() - field) / self.length;
        let squared = operators[samples[0].geometry].squared_gradient(difference);
        // F − F̂ = ∇(u − û): the length that made u dimensionless is put back.
        Ok(mean_distance(displacement, simulated, unit, floor)
            + (squared + SQUARED_NORM_FLOOR).sqrt().mean() * (weight * self.length))
    }
}
