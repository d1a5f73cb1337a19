//! TrainingProgress and report of a run.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use crate::{Concern, Result, Surrogate};

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
