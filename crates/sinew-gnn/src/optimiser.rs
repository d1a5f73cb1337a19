//! Optimisers: Adam, and Muon as the published training figures used it.

mod adam;
mod clip;
mod muon;
mod update;

pub(crate) use clip::clip_global_norm;
pub use muon::MuonConfig;

use std::path::Path;

use burn::optim::GradientsParams;
use serde::{Deserialize, Serialize};
use update::{AllMoments, Descent, apply, collect, read_moments, write_moments};

use crate::emulator::Emulator;
use crate::error::Result;

/// Added to the root of Adam's second moment.
const ADAM_EPSILON: f32 = 1e-8;

/// A choice of optimiser, as stored in configurations and checkpoints.
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
}

impl Default for OptimiserConfig {
    fn default() -> Self {
        Self::Muon(MuonConfig::default())
    }
}

/// An optimiser with its history.
#[derive(Debug, Clone)]
pub(crate) struct Optimiser {
    config: OptimiserConfig,
    steps: usize,
    moments: AllMoments,
}

impl Optimiser {
    /// Without history.
    pub(crate) fn new(config: OptimiserConfig) -> Self {
        Self { config, steps: 0, moments: AllMoments::new() }
    }

    /// Weights after one step.
    pub(crate) fn step(
        &mut self,
        learning_rate: f64,
        emulator: Emulator,
        gradients: GradientsParams,
    ) -> Emulator {
        self.steps += 1;
        let mut updates = collect(&emulator, gradients, &mut self.moments);
        let (step, mut kept) = (learning_rate as f32, 1.0);
        match self.config {
            OptimiserConfig::Adam { beta1, beta2 } => {
                adam::direct([beta1, beta2], self.steps, &mut updates);
            }
            OptimiserConfig::AdamW { beta1, beta2, weight_decay } => {
                adam::direct([beta1, beta2], self.steps, &mut updates);
                kept -= step * weight_decay;
            }
            OptimiserConfig::Muon(ref config) => muon::direct(config, self.steps, &mut updates),
        }
        apply(emulator, updates, &mut self.moments, Descent { kept, step })
    }

    /// Writes the number of steps and the moments to a file.
    pub(crate) fn save(&self, path: &Path) -> Result<()> {
        write_moments(path, self.steps, &self.moments)
    }

    /// Reads what [`Optimiser::save`] wrote.
    pub(crate) fn load(&mut self, path: &Path) -> Result<()> {
        (self.steps, self.moments) = read_moments(path)?;
        Ok(())
    }
}
