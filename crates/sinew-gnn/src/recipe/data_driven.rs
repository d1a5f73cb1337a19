//! A network on simulated displacements.

use crate::error::Result;
use crate::network::{Network, OutputCoordinates, Plan, TrainedNetwork, train};
use crate::objective::{DataFit, GradientOperator, Objective};
use crate::training::{TrainingBudget, TrainingConfig};
use serde::{Deserialize, Serialize};
use sinew_emulate::coordinates::OutputScale;
use sinew_emulate::parts::Session;
use sinew_emulate::{Body, Record, Simulations, TestSet};

/// Mean nodal distance to simulated displacements, thesis (3.11), in the directions in which the simulations differ
/// beyond a polynomial in the parameters.
#[doc(alias = "supervised")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DataDriven {
    /// Simulations to learn from.
    pub simulations: usize,
    /// Weight of the distance between deformation gradients, thesis (B.1); 0 leaves them out.
    pub gradient_weight: f64,
    /// Coordinates of the outputs.
    pub coordinates: OutputCoordinates,
    /// Sizes of the network.
    pub network: Network,
    /// Optimiser, schedule, batch, steps.
    pub training: TrainingConfig,
}

impl Default for DataDriven {
    fn default() -> Self {
        let training = TrainingConfig {
            batch: 8,
            budget: TrainingBudget::Steps(2000),
            embedding_share: 0.04,
            ..TrainingConfig::default()
        };
        Self {
            simulations: 200,
            gradient_weight: 0.0,
            coordinates: OutputCoordinates::Simulations,
            network: Network::default(),
            training,
        }
    }
}

impl DataDriven {
    pub(crate) fn model(
        &self,
        session: &mut Session<'_, '_>,
        held_out: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<TrainedNetwork> {
        let simulations = session.training(self.simulations)?;
        let Simulations { thetas, fields, .. } = &simulations;
        let scale = OutputScale::root_mean_square(3, fields.iter().map(Vec::as_slice))?;
        let (body, length) = (session.body, scale.length());
        let fields = Some(&fields[..]);
        let plan = Plan {
            recipe: "dd",
            network: &self.network,
            coordinates: &self.coordinates,
            training: &self.training,
            objective: &|| self.objective(body, length),
            thetas,
            fields,
            scale,
            energy: 0.0,
            least_work: 0.0,
            held_out,
        };
        train(session, &plan, record)
    }

    fn objective(&self, body: &Body, length: f64) -> Result<Box<dyn Objective>> {
        let fit = DataFit::new(length)?;
        if self.gradient_weight == 0.0 {
            return Ok(Box::new(fit));
        }
        let points = 0..body.volumes.len();
        let operator = GradientOperator {
            nodes_per_cell: body.nodes_per_cell,
            // Of every quadrature point.
            cells: points.flat_map(|point| body.nodes_of_point(point).to_vec()).collect(),
            shape_gradients: body.shape_gradients.as_flattened().to_vec(),
        };
        Ok(Box::new(fit.with_gradients(self.gradient_weight, vec![operator])?))
    }
}
