//! The best weights of a run, and the way back to them.

use burn::module::Module;

use super::trainer::{Best, Trainer};
use crate::error::Error;

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
