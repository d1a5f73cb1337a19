//! Progress and report of a run, and faults of one that did not diverge.

use crate::{Result, Surrogate, Trainer};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// State of a run after a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainingProgress {
    /// Steps made.
    pub step: usize,
    /// Steps of the whole run, estimated under a time budget.
    pub steps: usize,
    /// Share of the budget spent, from 0 to 1.
    pub share: f64,
    /// Loss of this step, before its update.
    pub loss: f64,
    /// Norm of the gradient before clipping.
    pub gradient_norm: f64,
    /// Learning rate of this step.
    pub learning_rate: f64,
    /// Seconds of training, evaluations not counted.
    pub seconds: f64,
    /// Seconds until the budget is spent.
    pub remaining_seconds: f64,
}

/// Receives the progress of a run. `()` ignores it.
pub trait TrainingObserver {
    /// Called after every step; breaking ends the run after a last evaluation and checkpoint.
    fn progress(&mut self, progress: &TrainingProgress) -> ControlFlow<()> {
        let _ = progress;
        ControlFlow::Continue(())
    }

    /// Called at every evaluation with the current weights; its time does not count as training.
    ///
    /// Returns their error on held-out cases if there are any: not negative, and infinite if it is not a number. The run
    /// keeps the weights with the lowest error. If the error becomes much larger, it returns to them with a smaller
    /// learning rate. Without this error, the loss of the validation samples is taken.
    ///
    /// # Errors
    /// Whatever is to end the run.
    fn evaluate(&mut self, surrogate: &Surrogate, point: &HistoryPoint) -> Result<Option<f64>> {
        let _ = (surrogate, point);
        Ok(None)
    }

    /// Called after an evaluation in the second half of the budget, for each reason not to trust the weights.
    fn concern(&mut self, concern: &Concern) {
        let _ = concern;
    }
}

impl TrainingObserver for () {}

/// One evaluation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HistoryPoint {
    /// Steps made.
    pub step: usize,
    /// Seconds of training, evaluations not counted.
    pub seconds: f64,
    /// Mean training loss since the evaluation before.
    pub loss: f64,
    /// Standard deviation of that mean: every batch has other samples.
    pub deviation: f64,
    /// Mean loss of the validation samples, where there are any.
    pub validation: Option<f64>,
}

/// Summary of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainingReport {
    /// Steps made.
    pub steps: usize,
    /// Seconds of training, evaluations not counted.
    pub seconds: f64,
    /// Whether the observer ended it, and not its budget.
    pub interrupted: bool,
    /// Step whose weights were kept: the best by the observer's error or the validation loss, the last one without either.
    pub kept_step: usize,
    /// Error or validation loss of the kept weights.
    pub kept_error: Option<f64>,
    /// Returns to the best weights, each of which halved the learning rate.
    pub returns: usize,
    /// All evaluations.
    pub history: Vec<HistoryPoint>,
    /// Reasons not to trust the kept weights; none after a training that went well.
    pub concerns: Vec<Concern>,
}

/// Standard deviations of a mean loss that count as noise of the drawn samples: the lowest of twenty means of about six
/// batches is easily off by four.
const NOISE: f64 = 5.0;

/// Most geometries that an evaluation looks at: message passing on one costs a third of a step.
const GEOMETRIES: usize = 32;

/// Concern about the losses of a run, beyond their noise. `exact`, the loss of all samples after the last step, has no
/// noise. A loss of zero outputs that is not finite raises none.
fn of_losses(history: &[HistoryPoint], of_zero_output: f64, exact: Option<f64>) -> Option<Concern> {
    let last = history.last()?;
    let (loss, deviation) = exact.map_or((last.loss, last.deviation), |exact| (exact, 0.0));
    if !of_zero_output.is_finite() {
        return None;
    }
    if loss - NOISE * deviation >= of_zero_output {
        return Some(Concern::NothingLearned { loss, of_zero_output });
    }
    let lowest = history.iter().min_by(|a, b| a.loss.total_cmp(&b.loss))?;
    let lost = (loss - lowest.loss) / (of_zero_output - lowest.loss);
    let certain = loss - lowest.loss > NOISE * deviation.hypot(lowest.deviation);
    let rose = lost > 0.5 && certain;
    rose.then_some(Concern::LossRose { lowest: lowest.loss, step: lowest.step, loss })
}

impl Trainer {
    /// Concerns about the weights. Before the training is `over`: those of the latest evaluation, from one batch per geometry, of at
    /// most 32 geometries. After it: the kept ones, from all parameters of the training.
    pub(super) fn concerns(&mut self, over: bool) -> Result<Vec<Concern>> {
        let of_zero_output = match self.loss_of_zero_output {
            Some(loss) => loss,
            None => *self.loss_of_zero_output.insert(self.zero_output_loss()?),
        };
        let (inadmissible, loss) = self.of_states(over)?;
        let history = &self.progress.history;
        // Evaluations after the kept weights do not count.
        let kept = self.best.as_ref().filter(|_| over).map(|(best, _)| best.step);
        let until = history.partition_point(|point| kept.is_none_or(|step| point.step <= step));
        let of_losses = of_losses(&history[..until], of_zero_output, over.then_some(loss));
        Ok(of_losses.into_iter().chain(inadmissible).collect())
    }

    /// Mean loss over the training samples without the network's outputs.
    fn zero_output_loss(&self) -> Result<f64> {
        self.mean_loss(&self.batches(&self.data.training), |samples| {
            let output = &self.surrogate.prepared[samples[0].geometry].output;
            Ok(output.without_network(&self.surrogate.parameters_of(samples)?))
        })
    }

    /// Concern about predictions, and their mean loss.
    fn of_states(&self, over: bool) -> Result<(Option<Concern>, f64)> {
        let mut batches = self.batches(&self.data.training);
        if !over {
            batches.dedup_by_key(|samples| samples[0].geometry);
            let apart = batches.len().div_ceil(GEOMETRIES).max(1);
            batches = batches.into_iter().step_by(apart).collect();
        }
        let (mut predictions, mut inadmissible) = (self.predictions(), 0);
        let loss = self.mean_loss(&batches, |samples| {
            let displacement = predictions(samples)?;
            inadmissible += self.objective.inadmissible(samples, displacement.clone());
            Ok(displacement)
        })?;
        let samples = batches.iter().map(Vec::len).sum();
        let concern = (inadmissible > 0).then_some(Concern::Inadmissible { inadmissible, samples });
        Ok((concern, loss))
    }
}

/// A reason not to trust the weights that a training leaves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
#[serde(rename_all = "kebab-case")]
pub enum Concern {
    /// The loss is not below that of zero outputs, which are one displacement for all parameters, or the Taylor polynomial.
    #[error(
        "nothing was learned: the mean loss is {loss:.3e}, that without the network's outputs {of_zero_output:.3e}; train \
         for longer, or choose another recipe"
    )]
    NothingLearned { loss: f64, of_zero_output: f64 },
    /// The loss rose by more than half of its earlier reduction.
    #[error(
        "the mean loss rose from {lowest:.3e} at step {step} to {loss:.3e}; train for longer, or choose another recipe"
    )]
    LossRose { lowest: f64, step: usize, loss: f64 },
    /// Predictions that invert a cell, or whose energy only barriers bound.
    #[error(
        "{inadmissible} of {samples} predictions at the parameters of the training invert a cell, or stretch it so far \
         that only barriers bound its energy; train for longer, narrow the ranges of the parameters, or choose another \
         recipe"
    )]
    Inadmissible { inadmissible: usize, samples: usize },
}
