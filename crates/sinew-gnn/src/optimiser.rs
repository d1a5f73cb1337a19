//! Optimisers: Adam, and Muon as the published training figures used it; Burn's fit too.

mod adam;
mod clip;
mod muon;
mod update;

pub(crate) use clip::clip_global_norm;
pub use muon::MuonConfig;

use std::path::Path;

use adam::Adam;
use burn::optim::{GradientsParams, ModuleOptimizer};
use muon::Muon;
use serde::{Deserialize, Serialize};

use crate::emulator::Emulator;
use crate::error::{Error, Result};

/// Added to the root of Adam's second moment.
const ADAM_EPSILON: f32 = 1e-8;

/// One update of all weights. Every Burn [`ModuleOptimizer`] is one.
pub trait Optimiser: Send {
    /// Weights after one step.
    fn step(
        &mut self,
        learning_rate: f64,
        emulator: Emulator,
        gradients: GradientsParams,
    ) -> Emulator;

    /// Writes the state (moments, counts) to a file.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn save(&self, path: &Path) -> Result<()>;

    /// Reads the state that [`Optimiser::save`] wrote.
    ///
    /// # Errors
    /// A file that cannot be read or belongs to another optimiser.
    fn load(&mut self, path: &Path) -> Result<()>;
}

impl Optimiser for ModuleOptimizer {
    fn step(
        &mut self,
        learning_rate: f64,
        emulator: Emulator,
        gradients: GradientsParams,
    ) -> Emulator {
        ModuleOptimizer::step(self, learning_rate, emulator, gradients)
    }

    fn save(&self, path: &Path) -> Result<()> {
        ModuleOptimizer::save(self, path).map_err(|error| unusable(path, &error))
    }

    fn load(&mut self, path: &Path) -> Result<()> {
        *self = self.clone().load(path).map_err(|error| unusable(path, &error))?;
        Ok(())
    }
}

fn unusable(path: &Path, error: &dyn std::fmt::Display) -> Error {
    Error::Format { path: path.into(), reason: error.to_string() }
}

/// A choice of optimiser, as stored in configurations and checkpoints. Others implement
/// [`Optimiser`] and go to [`crate::Trainer::with_optimiser`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum OptimiserConfig {
    /// Adam (thesis).
    Adam {
        /// Decay of the first moment.
        beta1: f32,
        /// Decay of the second moment.
        beta2: f32,
    },
    /// Adam with decoupled weight decay.
    AdamW {
        /// Decay of the first moment.
        beta1: f32,
        /// Decay of the second moment.
        beta2: f32,
        /// Share of a weight lost per unit of learning rate.
        weight_decay: f32,
    },
    /// Muon on matrices, Adam on vectors.
    Muon(MuonConfig),
}

impl OptimiserConfig {
    /// Adam with its usual decays of 0.9 and 0.999.
    pub fn adam() -> Self {
        Self::Adam { beta1: 0.9, beta2: 0.999 }
    }

    /// An optimiser without history.
    pub(crate) fn build(&self) -> Box<dyn Optimiser> {
        match *self {
            Self::Adam { beta1, beta2 } => Box::new(Adam::new(beta1, beta2, 0.0)),
            Self::AdamW { beta1, beta2, weight_decay } => {
                Box::new(Adam::new(beta1, beta2, weight_decay))
            }
            Self::Muon(ref config) => Box::new(Muon::new(config.clone())),
        }
    }
}

impl Default for OptimiserConfig {
    fn default() -> Self {
        Self::Muon(MuonConfig::default())
    }
}
