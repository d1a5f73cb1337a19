//! The training loop.

use super::clock::Clock;
use super::config::TrainingConfig;
use super::progress::{HistoryPoint, TrainingObserver, TrainingProgress, TrainingReport};
use super::sampler::Sampler;
use crate::optimiser::Optimiser;
use crate::{DataSet, Embedding, Error, GraphNetwork, Objective, Result, Sample, Surrogate};
use burn::module::Module;
use burn::tensor::Tensor;
use sinew_emulate::coordinates::require_count;
use std::path::PathBuf;
use std::time::Instant;

/// Share of the budget from which on losses are judged. About a solution, zero outputs are good, and a good training needs
/// a third of its steps to beat them.
const JUDGED_FROM: f64 = 0.5;

/// Trains a [`Surrogate`] on a [`DataSet`] by an [`Objective`].
///
/// Every step predicts a batch of parameter sets on one geometry from one message-passing pass.
/// Training starts, or after [`Trainer::resume`] continues, with [`Trainer::run`].
pub struct Trainer {
    pub(super) surrogate: Surrogate,
    /// The network on the device that records gradients.
    pub(super) emulator: GraphNetwork,
    pub(super) optimiser: Optimiser,
    pub(super) sampler: Sampler,
    pub(super) config: TrainingConfig,
    pub(super) progress: RunState,
    pub(super) best: Option<(Best, GraphNetwork)>,
    pub(super) objective: Box<dyn Objective>,
    pub(super) data: DataSet,
    /// Mean training loss of a network without outputs, once it was needed.
    pub(super) loss_of_zero_output: Option<f64>,
    /// Embeddings of all geometries by a frozen encoder; empty before, and after a return to other weights.
    pub(super) frozen: Vec<Embedding>,
    /// Folder that a checkpoint is written to at every evaluation.
    pub checkpoints: Option<PathBuf>,
}

/// Record of the best weights so far, with the history of the optimiser that made them.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(super) struct Best {
    /// The observer's error, or the validation loss.
    pub error: f64,
    pub step: usize,
    pub optimiser: Optimiser,
    /// Rows of the embeddings that are weights, see [`GraphNetwork::embedded_nodes`].
    pub embedded_nodes: Vec<Vec<usize>>,
}

/// Counters of a run that a checkpoint keeps.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct RunState {
    pub clock: Clock,
    pub evaluations: usize,
    /// Losses of the steps since the latest evaluation.
    pub losses: Vec<f64>,
    pub history: Vec<HistoryPoint>,
    /// Returns to the best weights.
    pub returns: usize,
}

/// Mean, and standard deviation of the mean.
fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, squares.sqrt() / count)
}

impl Trainer {
    /// Prepares training of a surrogate that was made for `data`.
    ///
    /// # Errors
    /// Data, objective and surrogate that do not fit each other, or settings that admit no training.
    pub fn new(
        surrogate: Surrogate,
        data: DataSet,
        objective: Box<dyn Objective>,
        config: TrainingConfig,
    ) -> Result<Self> {
        config.check()?;
        data.check(surrogate.emulator().config.dimensions)?;
        objective.check(&data)?;
        let known = surrogate.geometries.len();
        require_count("geometries of the data", data.geometries.len(), known)?;
        for (own, known) in data.geometries.iter().zip(&surrogate.geometries) {
            let nodes = known.topology.real_nodes;
            require_count("nodes of a geometry", own.topology.real_nodes, nodes)?;
        }
        for (index, sample) in data.training.iter().chain(&data.validation).enumerate() {
            surrogate.scales.parameters.require_inside(index, &sample.theta)?;
        }
        Ok(Self {
            emulator: surrogate.emulator.clone().train(),
            optimiser: Optimiser::default(),
            sampler: Sampler::new(&data.training, data.geometries.len(), config.batch, config.seed),
            progress: RunState::default(),
            best: None,
            loss_of_zero_output: None,
            frozen: Vec::new(),
            checkpoints: None,
            surrogate,
            config,
            objective,
            data,
        })
    }

    /// Another peak of the learning rate, as after a divergence.
    pub fn with_learning_rate(mut self, learning_rate: f64) -> Self {
        self.config.learning_rate = learning_rate;
        self
    }

    /// Trains until the budget is spent or the observer breaks.
    ///
    /// Afterwards the surrogate holds the best weights of all evaluations by the observer's error or by the validation loss, or the
    /// last ones where there is neither. A run that has left its best weights returns to them and goes on with half the learning rate.
    /// The evaluation at an interruption does not choose weights, so a resumed run gives the numbers of an uninterrupted
    /// one.
    ///
    /// # Errors
    /// [`Error::Diverged`], an objective, an evaluation or a checkpoint that fails.
    pub fn run(&mut self, observer: &mut dyn TrainingObserver) -> Result<TrainingReport> {
        let mut interrupted = false;
        while !interrupted && self.progress.clock.share(self.config.budget) < 1.0 {
            let progress = match self.step() {
                Err(error) if self.survives(&error) => continue,
                made => made?,
            };
            interrupted = observer.progress(&progress).is_break();
            let share = self.progress.clock.share(self.config.budget);
            let due = (share * self.config.evaluations as f64) as usize;
            let decides = due > self.progress.evaluations;
            if interrupted || decides {
                self.progress.evaluations = due.max(self.progress.evaluations);
                self.evaluate(observer, decides)?;
            }
        }
        let (kept_step, kept_error) = self.keep_best();
        let concerns = self.concerns(true)?;
        let RunState { clock, ref history, returns, .. } = self.progress;
        Ok(TrainingReport {
            steps: clock.step,
            seconds: clock.seconds,
            interrupted,
            kept_step,
            kept_error,
            returns,
            history: history.clone(),
            concerns,
        })
    }

    /// The surrogate with its current weights, or the kept ones after [`Trainer::run`].
    pub fn surrogate(&self) -> &Surrogate {
        &self.surrogate
    }

    /// The surrogate with the weights of the latest step, when steps are made by hand.
    pub fn current_surrogate(&self) -> Surrogate {
        Surrogate { emulator: self.emulator.valid(), ..self.surrogate.clone() }
    }

    /// The surrogate, training done.
    pub fn into_surrogate(self) -> Surrogate {
        self.surrogate
    }

    /// One update of the weights.
    ///
    /// # Errors
    /// [`Error::Diverged`] if loss or gradient is not finite (the weights stay as they were), or a
    /// failing objective.
    pub fn step(&mut self) -> Result<TrainingProgress> {
        crate::fused::on_ready_threads(|| self.step_in_pool())
    }

    fn step_in_pool(&mut self) -> Result<TrainingProgress> {
        let start = Instant::now();
        let clock = self.progress.clock;
        let (budget, share) = (self.config.budget, self.config.embedding_share);
        if clock.rest.is_none() && clock.is_time_to_rest(budget, share) {
            self.progress.clock.rest = Some((clock.step, clock.seconds));
        }
        self.leave_message_passing();
        let probing = self.progress.clock.is_probing(budget, share);
        let constant = if probing { self.embeddings() } else { Vec::new() };
        let prepared = start.elapsed().as_secs_f64();
        let factor = self.config.schedule.factor(clock.step, clock.total_steps(budget, share));
        let learning_rate = self.config.learning_rate * factor * self.rate_after_returns();
        let samples: Vec<&Sample> =
            self.sampler.draw().iter().map(|&index| &self.data.training[index]).collect();
        let index = samples[0].geometry;
        let geometry = &self.surrogate.prepared[index];
        let local = constant.get(index).or(self.frozen.get(index)).cloned();
        let local = local.unwrap_or_else(|| self.surrogate.embedding(&self.emulator, index));
        let parameters = self.surrogate.parameters_of(&samples)?;
        let displacement = geometry.displacement(&self.emulator, local, &parameters);
        let loss = self.objective.loss(&samples, displacement)?;
        let (rule, pace) =
            (&self.config.optimiser, (learning_rate, self.config.gradient_norm_limit));
        let [value, gradient_norm] = self.optimiser.step(rule, pace, &mut self.emulator, loss);
        if !value.is_finite() || !gradient_norm.is_finite() {
            let emulator = self.emulator.valid();
            let local = self.surrogate.embedding(&emulator, index);
            let displacement = geometry.displacement(&emulator, local, &parameters);
            let inadmissible = self.objective.inadmissible(&samples, displacement);
            let (step, samples) = (clock.step + 1, samples.len());
            return Err(match inadmissible {
                0 => Error::Diverged { step, loss: value, gradient_norm, learning_rate },
                inadmissible => Error::InvertedCells { step, inadmissible, samples },
            });
        }
        let seconds = start.elapsed().as_secs_f64();
        if probing {
            self.progress.clock.probe = Some(seconds - prepared);
        }
        self.progress.clock.step += 1;
        self.progress.clock.seconds += seconds;
        self.progress.losses.push(value);
        let clock = self.progress.clock;
        Ok(TrainingProgress {
            step: clock.step,
            steps: clock.total_steps(budget, share).round() as usize,
            share: clock.share(budget),
            loss: value,
            gradient_norm,
            learning_rate,
            seconds: clock.seconds,
            remaining_seconds: clock.remaining_seconds(budget, share),
        })
    }

    /// Once message passing rests, makes the embeddings weights or constants, where they are not yet.
    pub(super) fn leave_message_passing(&mut self) {
        if self.progress.clock.rest.is_none() {
            return;
        }
        if !self.config.frozen_encoder {
            if self.emulator.embedding(0).is_none() {
                self.emulator = self.emulator.clone().with_embeddings(self.embeddings());
            }
        } else if self.frozen.is_empty() {
            self.frozen = self.embeddings();
        }
    }

    /// Embeddings of the geometries' nodes as they are now, as data.
    pub(super) fn embeddings(&self) -> Vec<Embedding> {
        let emulator = self.emulator.valid();
        let lifted = |geometry: usize| {
            let layers = self.surrogate.embedding(&emulator, geometry).into_iter();
            layers.map(Tensor::from_inner).collect()
        };
        (0..self.data.geometries.len()).map(lifted).collect()
    }

    /// Displacements of a batch by the latest weights, without gradients. Batches of one geometry that follow each other share its
    /// message passing.
    pub(super) fn predictions(&self) -> impl FnMut(&[&Sample]) -> Result<Tensor<3>> + '_ {
        let emulator = &self.surrogate.emulator;
        let mut latest = None;
        move |samples| {
            let index = samples[0].geometry;
            let local = match latest.take() {
                Some((of, local)) if of == index => local,
                _ => self.surrogate.embedding(emulator, index),
            };
            latest = Some((index, Embedding::clone(&local)));
            let parameters = self.surrogate.parameters_of(samples)?;
            Ok(self.surrogate.prepared[index].displacement(emulator, local, &parameters))
        }
    }

    /// Samples in batches of one geometry each.
    pub(super) fn batches<'a>(&self, samples: &'a [Sample]) -> Vec<Vec<&'a Sample>> {
        let of = |geometry| {
            let own = samples.iter().filter(move |sample| sample.geometry == geometry);
            let own: Vec<&Sample> = own.collect();
            own.chunks(self.config.batch).map(<[_]>::to_vec).collect::<Vec<_>>()
        };
        (0..self.data.geometries.len()).flat_map(of).collect()
    }

    /// Mean loss of the samples of some batches.
    pub(super) fn mean_loss(
        &self,
        batches: &[Vec<&Sample>],
        mut displacement: impl FnMut(&[&Sample]) -> Result<Tensor<3>>,
    ) -> Result<f64> {
        let (mut sum, mut count) = (0.0, 0);
        for samples in batches {
            let loss = self.objective.loss(samples, displacement(samples)?)?;
            sum += f64::from(loss.into_scalar::<f32>()) * samples.len() as f64;
            count += samples.len();
        }
        Ok(sum / count as f64)
    }

    /// Validation, observer and checkpoint; whether the error decides about the best weights.
    fn evaluate(&mut self, observer: &mut dyn TrainingObserver, decides: bool) -> Result<()> {
        self.surrogate.emulator = self.emulator.valid();
        let batches = self.batches(&self.data.validation);
        let validation = (!batches.is_empty())
            .then(|| self.mean_loss(&batches, self.predictions()))
            .transpose()?;
        let state = &mut self.progress;
        let (loss, deviation) = mean_and_deviation(&std::mem::take(&mut state.losses));
        let Clock { step, seconds, .. } = state.clock;
        let point = HistoryPoint { step, seconds, loss, deviation, validation };
        state.history.push(point);
        let error = observer.evaluate(&self.surrogate, &point)?.or(validation);
        let returned = decides && self.judge(error);
        // Weights that the run has left are not diagnosed.
        if !returned && self.progress.clock.share(self.config.budget) >= JUDGED_FROM {
            self.concerns(false)?.iter().for_each(|c| observer.concern(c));
        }
        match self.checkpoints.clone() {
            Some(directory) => self.save_checkpoint(&directory),
            None => Ok(()),
        }
    }
}
