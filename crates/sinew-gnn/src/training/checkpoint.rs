//! Checkpoints: everything a run needs to go on.

use std::path::Path;

use burn::tensor::Device;
use serde::{Deserialize, Serialize};

use super::sampler::{Sampler, SamplerState};
use super::trainer::{Best, RunState, Trainer};
use crate::optimiser::Optimiser;
use crate::store::{
    check_version, load_weights, open_directory, read_json, read_surrogate, replace_directory,
    save_weights, write_json, write_surrogate,
};
use crate::{DataSet, Error, Objective, Result, TrainingConfig};
use sinew_emulate::coordinates::require_count;

/// Version of the checkpoint format.
const VERSION: u32 = 5;
const RUN: &str = "run.json";
const BEST: &str = "best.bpk";

/// State of a run beside its weights.
#[derive(Serialize, Deserialize)]
pub(super) struct Run {
    version: u32,
    pub config: TrainingConfig,
    pub progress: RunState,
    pub sampler: SamplerState,
    pub optimiser: Optimiser,
    /// Number of training samples.
    pub samples: usize,
    best: Option<Best>,
}

impl Trainer {
    /// Continues from the checkpoint in `directory`, exactly where it was written if the budget
    /// is in steps. Data and objective are given again, as they were.
    ///
    /// # Errors
    /// A checkpoint that cannot be read, or that does not fit the data.
    pub fn resume(
        directory: &Path,
        data: DataSet,
        objective: Box<dyn Objective>,
        device: &Device,
    ) -> Result<Self> {
        let folder = open_directory(directory);
        check_version(&folder.join(RUN), VERSION)?;
        let run: Run = read_json(&folder.join(RUN))?;
        let surrogate = read_surrogate(&folder, device)?;
        let load = |best: Best| {
            let emulator = surrogate.emulator.clone();
            let emulator = load_weights(emulator, &best.embedded_nodes, &folder.join(BEST))?;
            Ok::<_, Error>((best, emulator))
        };
        let best = run.best.map(load).transpose()?;
        let mut trainer = Self::new(surrogate, data, objective, run.config)?;
        let (samples, geometries) = (&trainer.data.training, trainer.data.geometries.len());
        require_count("training samples", samples.len(), run.samples)?;
        trainer.sampler = Sampler::resume(samples, geometries, trainer.config.batch, run.sampler);
        trainer.optimiser = run.optimiser;
        trainer.progress = run.progress;
        trainer.best = best;
        trainer.checkpoints = Some(directory.into());
        Ok(trainer)
    }

    /// Writes weights, optimiser, position and random state to `directory`, replacing what is there at once.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn save_checkpoint(&self, directory: &Path) -> Result<()> {
        let run = Run {
            version: VERSION,
            config: self.config.clone(),
            progress: self.progress.clone(),
            sampler: self.sampler.state.clone(),
            optimiser: self.optimiser.clone(),
            samples: self.data.training.len(),
            best: self.best.as_ref().map(|(best, _)| best.clone()),
        };
        replace_directory(directory, |folder| {
            write_surrogate(&self.current_surrogate(), folder)?;
            if let Some((_, emulator)) = &self.best {
                save_weights(emulator, &folder.join(BEST))?;
            }
            write_json(&folder.join(RUN), &run)
        })
    }
}
