//! A network by minimum potential energy.

use crate::error::Result;
use crate::network::{Network, OutputCoordinates, Plan, TrainedNetwork, newton_step, train};
use crate::objective::{MinimumPotential, Objective};
use crate::training::{TrainingBudget, TrainingConfig};
use serde::{Deserialize, Serialize};
use sinew_emulate::coordinates::OutputScale;
use sinew_emulate::parts::{Session, Stream, norm, timed, work};
use sinew_emulate::{Body, Record, TestSet, Warning};
use sinew_energy::Barriers;
use sinew_fem::Solver;
use std::sync::Arc;

/// Mean potential energy, thesis (3.12): no simulation enters. One linear solve sets the scale of displacement and
/// energy; about the state that a first training predicts, some more make the outputs follow the parameters to second order
/// before the network learns what is beyond.
#[doc(alias("PINN", "deep energy method"))]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PhysicsInformed {
    /// Parameter sets to train at.
    pub parameter_sets: usize,
    /// Coordinates of the outputs.
    pub coordinates: OutputCoordinates,
    /// Sizes of the network.
    pub network: Network,
    /// Optimiser, schedule, batch, steps.
    pub training: TrainingConfig,
}

impl Default for PhysicsInformed {
    fn default() -> Self {
        let config = |steps, embedding_share, evaluations| TrainingConfig {
            batch: 8,
            learning_rate: 8e-3,
            budget: TrainingBudget::Steps(steps),
            embedding_share,
            evaluations,
            ..TrainingConfig::default()
        };
        Self {
            parameter_sets: 1000,
            coordinates: OutputCoordinates::MotionsAfter(config(400, 0.05, 5)),
            network: Network::default(),
            training: config(2000, 0.02, 20),
        }
    }
}

impl PhysicsInformed {
    pub(crate) fn model(
        &self,
        session: &mut Session<'_, '_>,
        held_out: &TestSet<'_>,
        record: &mut Record,
    ) -> Result<TrainedNetwork> {
        let body = session.body;
        let thetas =
            session.thetas(session.options.design, self.parameter_sets, Stream::Training)?;
        let (typical, centre) = (typical(body, &thetas), body.centre());
        let linear_response =
            timed(&mut record.prepare_s, || Solver::new(body)?.linear_response(&typical))?;
        let potential = Arc::new(body.clone().with_barriers(Barriers::default()));
        let energy =
            MinimumPotential::energy_of_linear_response(&*potential, &linear_response, &typical)?;
        let objective = || -> Result<Box<dyn Objective>> {
            Ok(Box::new(MinimumPotential::new(vec![potential.clone()], energy)?))
        };
        let scale = OutputScale::root_mean_square(3, [&linear_response[..]])?;
        let plan = Plan {
            recipe: "pi",
            network: &self.network,
            coordinates: &self.coordinates,
            training: &self.training,
            objective: &objective,
            thetas: &thetas,
            fields: None,
            scale,
            energy,
            least_work: if typical == centre { 0.0 } else { energy },
            held_out,
        };
        let network = train(session, &plan, record)?;
        judge_equilibrium(session, &network.fixed.predict(&[centre])?.concat(), plan.least_work)?;
        Ok(network)
    }
}

/// Parameters that set sizes of displacement and energy: the centre of the ranges, or where its loads nearly vanish, as of a pressure from −1 to
/// 1 kPa, those to train at with the median force at rest.
fn typical(body: &Body, thetas: &[Vec<f64>]) -> Vec<f64> {
    /// Forces at the centre \[relative to the median\].
    const VANISHING: f64 = 0.1;
    /// Parameter sets that are looked at.
    const TRIED: usize = 99;
    let force = |theta: &[f64]| {
        let mut force = vec![0.0; 3 * body.nodes];
        body.value_and_gradient(&vec![0.0; 3 * body.nodes], theta, &mut force);
        norm(&force)
    };
    let mut forces: Vec<_> = thetas.iter().take(TRIED).map(|theta| (force(theta), theta)).collect();
    forces.sort_by(|a, b| a.0.total_cmp(&b.0));
    match forces.get(forces.len() / 2) {
        Some((median, theta)) if force(&body.centre()) < VANISHING * median => theta.to_vec(),
        _ => body.centre(),
    }
}

/// Warns if the prediction is far from equilibrium: without simulations this is the only check of a training.
fn judge_equilibrium(
    session: &mut Session<'_, '_>,
    predicted: &[f64],
    least_work: f64,
) -> Result<()> {
    /// Gain of a Newton step \[relative to the loads' work\], about the relative error of the energy.
    const FAR: f64 = 1e-2;
    match newton_step(session.body, predicted)? {
        Some(step) => {
            let work = work(session.body, predicted).max(least_work);
            let excess = 0.5 * step.energy_norm.powi(2) / work;
            if excess > FAR {
                session.warn(Warning::FarFromEquilibrium { excess });
            }
        }
        None => {
            let of = "for the centre of the parameter range".into();
            session.warn(Warning::Inverted { of });
        }
    }
    Ok(())
}
