//! Position of a run in its budget.

use super::config::TrainingBudget;
use serde::{Deserialize, Serialize};

/// Steps made and seconds spent on them.
///
/// Steps without message passing are cheaper. Under a time budget the number of steps is estimated from both costs, so that
/// schedules refer to the same shares of the steps as under a budget of steps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Clock {
    pub step: usize,
    pub seconds: f64,
    /// Seconds of the one step made without message passing, to measure its cost.
    pub probe: Option<f64>,
    /// Steps and seconds after which message passing ends.
    pub rest: Option<(usize, f64)>,
}

/// Step, from zero, that measures the cost without message passing under a time budget. The steps before it warm the
/// caches.
const PROBE_STEP: usize = 2;

impl Clock {
    /// Share of the budget that is spent, from 0 to 1.
    pub(super) fn share(&self, budget: TrainingBudget) -> f64 {
        let share = match budget {
            TrainingBudget::Steps(steps) => self.step as f64 / steps as f64,
            TrainingBudget::Seconds(seconds) => self.seconds / seconds,
        };
        share.min(1.0)
    }

    /// Whether the next step measures the cost of a step without message passing.
    pub(super) fn is_probing(&self, budget: TrainingBudget, embedding_share: f64) -> bool {
        let mixed = embedding_share > 0.0 && embedding_share < 1.0;
        let due = self.rest.is_none() && self.step == PROBE_STEP;
        mixed && matches!(budget, TrainingBudget::Seconds(_)) && due
    }

    /// Whether `embedding_share` of the steps are made.
    pub(super) fn is_time_to_rest(&self, budget: TrainingBudget, embedding_share: f64) -> bool {
        self.step as f64 >= embedding_share * self.total_steps(budget, embedding_share)
    }

    /// Steps of the whole run; under a time budget estimated from the pace so far, and at least one more.
    pub(super) fn total_steps(&self, budget: TrainingBudget, embedding_share: f64) -> f64 {
        let seconds = match budget {
            TrainingBudget::Steps(steps) => return steps as f64,
            TrainingBudget::Seconds(seconds) => seconds,
        };
        let [whole, resting] = self.costs();
        let total = match self.rest {
            Some(_) => self.step as f64 + (seconds - self.seconds) / resting,
            None => seconds / (embedding_share * whole + (1.0 - embedding_share) * resting),
        };
        // Before the first step the pace is no number, and `max` gives the one step.
        total.max(self.step as f64 + 1.0)
    }

    /// Seconds until the budget is spent, at the pace so far.
    pub(super) fn remaining_seconds(&self, budget: TrainingBudget, embedding_share: f64) -> f64 {
        match budget {
            TrainingBudget::Seconds(seconds) => (seconds - self.seconds).max(0.0),
            TrainingBudget::Steps(_) if self.step == 0 => f64::INFINITY,
            TrainingBudget::Steps(steps) => {
                let [whole, resting] = self.costs();
                let all = steps as f64;
                let left = all - self.step as f64;
                let until_rest = match self.rest {
                    Some(_) => 0.0,
                    None => (embedding_share * all - self.step as f64).clamp(0.0, left),
                };
                until_rest * whole + (left - until_rest) * resting
            }
        }
    }

    /// Seconds of a step with and without message passing.
    fn costs(&self) -> [f64; 2] {
        let (steps, seconds) = self.rest.unwrap_or((self.step, self.seconds));
        let (probes, probed) = self.probe.map_or((0, 0.0), |cost| (1, cost));
        let whole = (seconds - probed) / (steps - probes) as f64;
        let since = self.rest.map(|(steps, seconds)| (self.step - steps, self.seconds - seconds));
        let resting = match since {
            Some((steps, seconds)) if steps > 0 => seconds / steps as f64,
            _ => self.probe.unwrap_or(whole),
        };
        [whole, resting]
    }
}
