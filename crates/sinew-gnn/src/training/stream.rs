//! Training on a stream of geometries, none of which is kept.

use burn::module::Module;
use burn::tensor::Tensor;

use super::config::{Budget, TrainingConfig};
use crate::data::{DataSet, Geometry, Sample};
use crate::emulator::Emulator;
use crate::error::{Error, Result};
use crate::objective::{Batch, Objective};
use crate::optimiser::Optimiser;
use crate::surrogate::Surrogate;

/// One geometry of a stream, with the samples and the objective of one step.
pub struct GeometryBatch {
    /// The geometry.
    pub geometry: Geometry,
    /// Parameter sets on it, all with the geometry's index zero.
    pub samples: Vec<Sample>,
    /// Objective there; it knows one geometry.
    pub objective: Box<dyn Objective>,
}

/// Trains a [`Surrogate`] on a stream of geometries, for unseen shapes.
///
/// A step takes as many batches as it is given, and forgets them. Message passing is trained to the end.
pub struct StreamTrainer {
    surrogate: Surrogate,
    emulator: Emulator,
    optimiser: Optimiser,
    config: TrainingConfig,
    steps: usize,
    /// Successive steps without a finite loss or gradient.
    lost: usize,
}

/// Number of lost steps in a row from which on a training has diverged.
const MOST_LOST: usize = 10;

impl StreamTrainer {
    /// Trainer of a surrogate of the feature counts and scales of the stream.
    ///
    /// # Errors
    /// Settings that admit no training.
    pub fn new(surrogate: Surrogate, config: TrainingConfig) -> Result<Self> {
        config.check()?;
        let emulator = surrogate.emulator.clone().train();
        Ok(Self { surrogate, emulator, optimiser: Optimiser::default(), config, steps: 0, lost: 0 })
    }

    /// One update of the weights by the mean loss of some batches, which is returned. `share` is the part of the budget
    /// that is spent, for the schedule of the learning rate.
    ///
    /// The energy of a body in the stream may overflow. A batch whose loss is not finite is left out. If the gradient is
    /// not finite, the weights do not change.
    ///
    /// # Errors
    /// A batch whose parts do not fit each other, [`Error::Diverged`] after ten steps in a row that taught nothing.
    pub fn step(&mut self, batches: &[GeometryBatch], share: f64) -> Result<f64> {
        sinew_burn::on_ready_threads(|| self.step_in_pool(batches, share))
    }

    fn step_in_pool(&mut self, batches: &[GeometryBatch], share: f64) -> Result<f64> {
        let mut losses = Vec::with_capacity(batches.len());
        for batch in batches {
            let loss = self.loss(batch)?;
            let value: f64 = loss.clone().into_scalar::<f32>().into();
            losses.push((loss, value));
        }
        let given = losses.len();
        losses.retain(|(_, value)| value.is_finite());
        let (kept, value) = (losses.len(), losses.iter().map(|(_, value)| value).sum::<f64>());
        self.steps += 1;
        // The number of steps is known only for a budget in steps.
        let total = match self.config.budget {
            Budget::Steps(steps) => steps as f64,
            Budget::Seconds(_) => self.steps as f64 / share.max(f64::MIN_POSITIVE),
        };
        let factor = self.config.schedule.factor(self.steps - 1, total);
        let learning_rate = self.config.learning_rate * factor;
        let mut gradient_norm = f64::NAN;
        if let Some(sum) = losses.into_iter().map(|(loss, _)| loss).reduce(|sum, loss| sum + loss) {
            let (rule, pace) =
                (&self.config.optimiser, (learning_rate, self.config.gradient_norm_limit));
            let loss = sum / kept as f64;
            let [mean, norm] = self.optimiser.step(rule, pace, &mut self.emulator, loss);
            if mean.is_finite() && norm.is_finite() {
                self.lost = 0;
                return Ok(value / kept as f64);
            }
            gradient_norm = norm;
        } else if given == 0 {
            return Err(Error::NothingToTrain("a step of a stream needs a batch"));
        }
        self.lost += 1;
        if self.lost < MOST_LOST {
            return Ok(f64::NAN);
        }
        Err(Error::Diverged { step: self.steps, loss: f64::NAN, gradient_norm, learning_rate })
    }

    fn loss(&self, batch: &GeometryBatch) -> Result<Tensor<1>> {
        let GeometryBatch { geometry, samples, objective } = batch;
        let data = DataSet {
            geometries: vec![geometry.clone()],
            training: samples.clone(),
            validation: Vec::new(),
        };
        if samples.is_empty() {
            return Err(Error::NothingToTrain("a batch without parameter sets"));
        }
        objective.check(&data)?;
        let tensors = self.surrogate.prepare(geometry)?.lifted();
        let samples: Vec<&Sample> = samples.iter().collect();
        let parameters = self.surrogate.parameters_of(&samples)?;
        let local = tensors.embedding(&self.emulator);
        let displacement = tensors.displacement(&self.emulator, local, parameters);
        objective.loss(&Batch { geometry: 0, samples: &samples }, displacement)
    }

    /// Steps made, lost ones included.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// The surrogate with its current weights.
    pub fn surrogate(&self) -> Surrogate {
        Surrogate { emulator: self.emulator.valid(), ..self.surrogate.clone() }
    }
}
