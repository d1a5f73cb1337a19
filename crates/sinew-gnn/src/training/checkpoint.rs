//! Checkpoints: everything a run needs to go on.

use std::path::{Path, PathBuf};

use burn::tensor::Device;
use serde::{Deserialize, Serialize};

use super::config::TrainingConfig;
use super::sampler::SamplerState;
use super::trainer::{Best, RunState, Trainer};
use crate::error::Result;
use crate::files::{open_directory, read_json, replace_directory, write_json};
use crate::store::{check_version, load_weights, read_surrogate, save_weights, write_surrogate};
use crate::surrogate::Surrogate;

/// Version of the checkpoint format.
const VERSION: u32 = 3;
const RUN: &str = "run.json";
const OPTIMISER: &str = "optimiser.bin";
const BEST: &str = "best.bpk";

#[derive(Serialize, Deserialize)]
struct Run {
    version: u32,
    config: TrainingConfig,
    progress: RunState,
    sampler: SamplerState,
    samples: usize,
    /// Validation loss and step of the best weights, and the rows of their embeddings.
    best: Option<(f64, usize, Vec<Vec<usize>>)>,
}

/// A checkpoint in memory.
pub(super) struct Saved {
    pub surrogate: Surrogate,
    pub config: TrainingConfig,
    pub progress: RunState,
    pub sampler: SamplerState,
    pub samples: usize,
    pub best: Option<Best>,
    /// File of the optimiser's state.
    pub optimiser: PathBuf,
}

pub(super) fn write(trainer: &Trainer, samples: usize, directory: &Path) -> Result<()> {
    let run = Run {
        version: VERSION,
        config: trainer.config.clone(),
        progress: trainer.progress.clone(),
        sampler: trainer.sampler.state().clone(),
        samples,
        best: trainer.best.as_ref().map(Best::description),
    };
    replace_directory(directory, |folder| {
        write_surrogate(&trainer.current_surrogate(), folder)?;
        if let Some(best) = &trainer.best {
            save_weights(&best.emulator, &folder.join(BEST))?;
        }
        trainer.optimiser.save(&folder.join(OPTIMISER))?;
        write_json(&folder.join(RUN), &run)
    })
}

pub(super) fn read(directory: &Path, device: &Device) -> Result<Saved> {
    let folder = open_directory(directory);
    check_version(&folder.join(RUN), VERSION)?;
    let run: Run = read_json(&folder.join(RUN))?;
    let surrogate = read_surrogate(&folder, device)?;
    let best = match run.best {
        None => None,
        Some((validation, step, rows)) => {
            let emulator = surrogate.emulator.clone();
            let emulator = load_weights(emulator, &rows, &folder.join(BEST))?;
            Some(Best { validation, step, emulator })
        }
    };
    Ok(Saved {
        surrogate,
        config: run.config,
        progress: run.progress,
        sampler: run.sampler,
        samples: run.samples,
        best,
        optimiser: folder.join(OPTIMISER),
    })
}
