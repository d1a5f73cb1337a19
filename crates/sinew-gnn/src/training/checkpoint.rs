//! Checkpoints, the best weights, and the way back to them.

use super::sampler::{Sampler, SamplerState};
use super::trainer::{Best, RunState, Trainer};
use crate::optimiser::Optimiser;
use crate::store::{
    load_weights, open_directory, read_json, read_surrogate, replace_directory, save_weights,
    write_json, write_surrogate,
};
use crate::{DataSet, Error, Objective, Result, TrainingConfig};
use burn::module::Module;
use burn::tensor::Device;
use serde::{Deserialize, Serialize};
use sinew_emulate::coordinates::require_count;
use std::path::Path;

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
        let run: Run = read_json(&folder.join(RUN), VERSION)?;
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

/// Error relative to the lowest one, above which a run has left its best weights. In a run that goes well the error varies
/// by less between evaluations.
const LEFT: f64 = 3.0;
/// Factor of the learning rate at every return.
const SMALLER: f64 = 0.5;
/// Returns after which a step that is not finite ends the run: the learning rate is then a thousandth, the least of a schedule.
const MOST_RETURNS: usize = 10;

/// Whether the error, or a loss that may be negative, is so high that the run has left its best weights.
fn has_left(error: f64, best: f64) -> bool {
    !error.is_finite() || (best > 0.0 && error > LEFT * best)
}

impl Trainer {
    /// Factor of the learning rate.
    pub(super) fn rate_after_returns(&self) -> f64 {
        SMALLER.powi(self.progress.returns as i32)
    }

    /// Keeps the weights of the latest evaluation if they are the best, or returns to the best if the run has left them.
    /// Returns whether it did. After the last step it does not return.
    pub(super) fn judge(&mut self, error: Option<f64>) -> bool {
        let Some(error) = error else { return false };
        let best = self.best.as_ref().map(|(best, _)| best.error);
        let improved = error.is_finite() && best.is_none_or(|best| error < best);
        if improved {
            let (step, emulator) = (self.progress.clock.step, self.surrogate.emulator.clone());
            let (optimiser, embedded_nodes) = (self.optimiser.clone(), emulator.embedded_nodes());
            self.best = Some((Best { error, step, optimiser, embedded_nodes }, emulator));
        }
        let over = self.progress.clock.share(self.config.budget) >= 1.0;
        let left = !over && best.is_some_and(|best| has_left(error, best));
        left && self.return_to_best()
    }

    /// Returns to the best weights from a step that is not finite, unless it is another error, or the learning rate is at its least.
    pub(super) fn survives(&mut self, error: &Error) -> bool {
        let diverged = matches!(error, Error::Diverged { .. } | Error::InvertedCells { .. });
        diverged && self.progress.returns < MOST_RETURNS && self.return_to_best()
    }

    /// Goes on from the best weights with a smaller learning rate; `false` where there are none.
    fn return_to_best(&mut self) -> bool {
        let Some((best, emulator)) = &self.best else { return false };
        self.emulator = emulator.clone().train();
        self.optimiser = best.optimiser.clone();
        // Weights from the time of message passing hold no embeddings of their own, and predict others.
        self.frozen.clear();
        self.leave_message_passing();
        self.surrogate.emulator = self.emulator.valid();
        self.progress.returns += 1;
        true
    }

    /// Puts the kept weights into the surrogate; their step, and their error where one was found.
    pub(super) fn keep_best(&mut self) -> (usize, Option<f64>) {
        let (emulator, kept) = match &self.best {
            Some((best, emulator)) => (emulator.clone(), (best.step, Some(best.error))),
            None => (self.emulator.valid(), (self.progress.clock.step, None)),
        };
        self.surrogate.emulator = emulator;
        kept
    }
}
