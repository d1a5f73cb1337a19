//! A network on simulated displacements, errors weighed by the stiffness.

use crate::coordinates::OutputCoordinates;
use crate::data::DataSet;
use crate::error::Result;
use crate::network::{Network, Plan, TrainedNetwork, TrainingData, train};
use crate::objective::{EnergyNormFit, Objective};
use crate::training::{TrainingBudget, TrainingConfig};
use serde::{Deserialize, Serialize};
use sinew_emulate::parts::{Session, admissible};
use sinew_emulate::{Record, TestSet};

/// Distance to simulated displacements in the energy norm, `‖K^½ (u − û)‖`, in coordinates in which that is plain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Hybrid {
    /// Simulations to learn from.
    pub simulations: usize,
    /// Coordinates of the outputs.
    pub coordinates: OutputCoordinates,
    /// Sizes of the network.
    pub network: Network,
    /// Optimiser, schedule, batch, steps.
    pub training: TrainingConfig,
}

impl Default for Hybrid {
    fn default() -> Self {
        let training = TrainingConfig {
            batch: 8,
            learning_rate: 8e-3,
            budget: TrainingBudget::Steps(2000),
            embedding_share: 0.02,
            ..TrainingConfig::default()
        };
        Self {
            simulations: 200,
            coordinates: OutputCoordinates::MotionsOfSimulation,
            network: Network::default(),
            training,
        }
    }
}

impl Hybrid {
    pub(crate) fn model(
        &self,
        session: &mut Session<'_, '_>,
        held_out: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<TrainedNetwork> {
        let simulations = session.training(self.simulations)?;
        let training_data = TrainingData::of(&simulations, held_out);
        let body = session.body;
        let central = admissible(body, training_data.central_simulation(body));
        let stiffness = body
            .stiffness(&central, &body.centre())
            .ok_or(sinew_emulate::coordinates::CoordinateError::NoStiffness)?;
        let objective = |data: &DataSet| -> Result<Box<dyn Objective>> {
            Ok(Box::new(EnergyNormFit::new(vec![stiffness.clone()], data)?))
        };
        let plan = Plan {
            recipe: "hybrid",
            network: self.network,
            coordinates: &self.coordinates,
            training: &self.training,
            objective: &objective,
        };
        train(session, &training_data, &plan, record)
    }
}
