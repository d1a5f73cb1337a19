//! Settings of a network that learns a population.

use crate::Result;
use crate::network::Network;
use serde::{Deserialize, Serialize};
use sinew_emulate::Body;
use sinew_gnn::{Budget, TrainingConfig};

/// A body of the population by its number, the same for the same number.
pub type Draw<'a> = dyn Fn(u64) -> Result<Body> + Sync + 'a;

/// State of a body that the network starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Start {
    /// A state near to equilibrium at the centre of the parameters' ranges: the linear response, or the first body's equilibrium carried
    /// over, and Newton steps from there. The network has to find the equilibrium.
    Near {
        /// Number of Newton steps.
        newton_steps: usize,
    },
    /// Equilibrium there, by one solve of every body. The network has to find what the parameters do beyond second order.
    Equilibrium,
}

impl Default for Start {
    fn default() -> Self {
        Self::Near { newton_steps: 0 }
    }
}

/// Loss of a network that learns a population.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Loss {
    /// Potential energy: bodies are not solved at the parameter sets that are learned.
    #[default]
    Energy,
    /// Mean nodal distance to solutions, which are made for every parameter set of every body.
    Simulations,
    /// Distance to such solutions in the energy norm of the body's stiffness at the centre of the parameters.
    SimulationsByStiffness,
}

/// Recipe of a network on a population: every step takes unseen bodies, each once.
///
/// Each body is prepared by a few linear systems: a [start](Start) and a Taylor expansion of second order in the
/// parameters. The network learns the remainder. With [`Start::Near`] only the first body is solved: its equilibrium is
/// another initial guess for the others.
///
/// ```
/// use sinew_emulate::Body;
/// use sinew_networks::{Error, Population};
/// use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_gnn::Budget;
/// use sinew_mesh::BeamShape;
/// use std::ops::ControlFlow;
///
/// // A population: a body for every number.
/// let draw = |number: u64| -> Result<Body, Error> {
///     let shape = [0.1 * (number % 17) as f64 - 0.8, 0.1 * (number % 13) as f64 - 0.6];
///     let refused = |reason: String| Error::Draw { index: number, reason };
///     let mesh = BeamShape::new(&shape).and_then(|shape| shape.tetrahedra([4, 2, 2]));
///     let scene = Scene::new(mesh.map_err(|error| refused(error.to_string()))?, NeoHookean)
///         .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
///         .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
///         .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
///         .support(Support::clamped("x_min"));
///     scene.lower().map_err(|error| refused(error.to_string()))
/// };
/// // Four steps, where some thousand make a good network.
/// let mut recipe = Population::default();
/// recipe.training.budget = Budget::Steps(4);
/// let emulator = recipe.train(&draw, 1, &mut |_, _| Ok(ControlFlow::Continue(())))?;
/// // A body of another mesh: what the network says, and two Newton steps.
/// let mesh = BeamShape::new(&[0.3])?.tetrahedra([5, 2, 2])?;
/// let body = Scene::new(mesh, NeoHookean)
///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
///     .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
///     .support(Support::clamped("x_min"))
///     .lower()?;
/// let answer = emulator.on(&body)?.correct(&[60.0, 90.0], 2)?;
/// assert_eq!(answer.displacement.len(), 3 * body.nodes);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Population {
    /// Sizes of the network.
    pub network: Network,
    /// The state that the outputs of a body are about.
    pub start: Start,
    /// Loss.
    pub loss: Loss,
    /// Bodies in a step.
    pub bodies: usize,
    /// Optimiser, schedule, steps; the batch is of parameter sets per body.
    pub training: TrainingConfig,
}

impl Default for Population {
    fn default() -> Self {
        Self {
            network: Network::default(),
            start: Start::default(),
            loss: Loss::default(),
            bodies: 2,
            training: TrainingConfig {
                batch: 8,
                learning_rate: 8e-3,
                budget: Budget::Steps(2000),
                evaluations: 10,
                ..TrainingConfig::default()
            },
        }
    }
}

/// Parameter sets that parts of the expansion are tried at.
pub(super) const TRIED: usize = 8;
