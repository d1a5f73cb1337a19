//! All recipes, those of networks included: one file each; adding one adds a file, a variant and a line of `predictor`.

mod data_driven;
mod physics_informed;

pub use crate::optimiser::OptimiserConfig;
pub use crate::training::{Schedule, TrainingConfig};
pub use data_driven::DataDriven;
pub use physics_informed::PhysicsInformed;
pub use sinew_emulate::recipe::{Regression, Taylor};

use crate::{KINDS, Network, OutputCoordinates};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sinew_emulate::parts::{Session, train_with};
use sinew_emulate::{Body, Emulator, Observer, Predictor, Record, TestSet, Train, TrainingOptions};

/// Recipe of an emulator. Its own settings have defaults that were measured (docs/design.md, docs/emulators.md).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "recipe", rename_all = "kebab-case")]
pub enum Recipe {
    /// A network on simulated displacements, thesis (3.11).
    DataDriven(DataDriven),
    /// A network by minimum potential energy, thesis (3.12): no simulation enters.
    PhysicsInformed(PhysicsInformed),
    /// Taylor expansion of second order about the solution at the centre of the parameters' ranges: nothing is trained.
    Taylor,
    /// Decomposition of few simulations and a Gaussian process: the best of a fixed geometry with few parameters.
    Regression(Regression),
}

impl Recipe {
    /// Outputs, sizes and training of its network, where it is one.
    pub(crate) fn network(&self) -> Option<(&OutputCoordinates, &Network, &TrainingConfig)> {
        match self {
            Self::DataDriven(DataDriven { coordinates, network, training, .. })
            | Self::PhysicsInformed(PhysicsInformed { coordinates, network, training, .. }) => {
                Some((coordinates, network, training))
            }
            Self::Taylor | Self::Regression(_) => None,
        }
    }

    /// A description of its network, continued by sizes, virtual nodes and training.
    fn with_settings(&self, made: String, record: &Record) -> String {
        let Some((_, network, training)) = self.network() else { return made };
        let Network { latent, width, cluster_width, message_passing_steps, .. } = network;
        let TrainingConfig { optimiser, learning_rate, batch, .. } = training;
        let rule = if let OptimiserConfig::Adam { .. } = optimiser { "Adam" } else { "Muon" };
        let levels: Vec<_> = record.virtual_nodes.iter().map(usize::to_string).collect();
        let levels = if levels.is_empty() { "none".into() } else { levels.join(", ") };
        format!(
            "{made}; {message_passing_steps} message-passing steps, embeddings of {latent}, hidden layers of {width} and of {cluster_width} for \
             clusters, virtual nodes: {levels}; {rule} at {learning_rate:e}, {batch} parameter sets a step"
        )
    }

    /// Trains an emulator of a body and checks its error estimate, see [`sinew_emulate::Train::train`].
    ///
    /// # Errors
    /// As [`sinew_emulate::Train::train`].
    pub fn train<'b>(
        &self,
        body: &'b Body,
        options: &TrainingOptions,
        observer: &mut dyn Observer,
    ) -> sinew_emulate::Result<Emulator<'b>> {
        train_with(self, body, options, observer, KINDS)
    }
}

impl Train for Recipe {
    fn key(&self) -> &'static str {
        match self {
            Self::DataDriven(_) => "dd",
            Self::PhysicsInformed(_) => "pi",
            Self::Taylor => "taylor",
            Self::Regression(_) => "regression",
        }
    }

    fn settings(&self) -> Value {
        serde_json::to_value(self).expect("settings are numbers and names")
    }

    fn about(&self, record: &Record) -> String {
        let made = match self {
            Self::DataDriven(_) => format!("network on {} simulations", record.simulations),
            Self::PhysicsInformed(_) if record.simulations > 0 => {
                format!("network by minimum potential energy about {} solutions", record.simulations)
            }
            Self::PhysicsInformed(_) => {
                "network by minimum potential energy, without simulations; a few linear solves give its scales and Taylor polynomial"
                    .into()
            }
            Self::Taylor => Taylor.about(record),
            Self::Regression(regression) => regression.about(record),
        };
        self.with_settings(made, record)
    }

    fn check(&self) -> sinew_emulate::Result<()> {
        if let Self::Regression(regression) = self { regression.check() } else { Ok(()) }
    }

    fn has_anchors(&self) -> bool {
        matches!(self, Self::Taylor | Self::PhysicsInformed(_))
    }

    fn network(&self) -> Option<Value> {
        let (_, network, _) = Self::network(self)?;
        serde_json::to_value(network).ok()
    }

    fn predictor(
        &self,
        session: &mut Session<'_, '_>,
        held_out: &TestSet<'_>,
        record: &mut Record,
    ) -> sinew_emulate::Result<Box<dyn Predictor>> {
        let network = match self {
            Self::DataDriven(recipe) => recipe.model(session, held_out, record)?,
            Self::PhysicsInformed(recipe) => recipe.model(session, held_out, record)?,
            Self::Taylor => return Taylor.predictor(session, held_out, record),
            Self::Regression(recipe) => return recipe.predictor(session, held_out, record),
        };
        Ok(Box::new(network))
    }
}

macro_rules! from_recipe {
    ($($name:ident),*) => {$(
        impl From<$name> for Recipe {
            fn from(recipe: $name) -> Self {
                Self::$name(recipe)
            }
        }
    )*};
}
from_recipe!(DataDriven, PhysicsInformed, Regression);
