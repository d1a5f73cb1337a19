//! A network on simulated displacements.

use crate::error::Result;
use crate::network::{Network, OutputCoordinates, Plan, TrainedNetwork, train};
use crate::objective::DataFit;
use crate::training::{TrainingBudget, TrainingConfig};
use serde::{Deserialize, Serialize};
use sinew_emulate::coordinates::OutputScale;
use sinew_emulate::parts::Session;
use sinew_emulate::{Record, Simulations, TestSet};

/// Mean nodal distance to simulated displacements, thesis (3.11), in the directions in which the simulations differ
/// beyond a polynomial in the parameters.
#[doc(alias = "supervised")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DataDriven {
    /// Simulations to learn from.
    pub simulations: usize,
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
        let length = scale.length();
        let fields = Some(&fields[..]);
        let plan = Plan {
            recipe: "dd",
            network: &self.network,
            coordinates: &self.coordinates,
            training: &self.training,
            objective: &|| Ok(Box::new(DataFit::new(length)?)),
            thetas,
            fields,
            scale,
            energy: 0.0,
            least_work: 0.0,
            held_out,
        };
        train(session, &plan, record)
    }
}
