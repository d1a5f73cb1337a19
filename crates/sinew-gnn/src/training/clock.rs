//! Position of a run in its budget.

use serde::{Deserialize, Serialize};

use super::config::TrainingBudget;

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

    /// Counts a step.
    pub(super) fn count(&mut self, seconds: f64) {
        self.step += 1;
        self.seconds += seconds;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_budget_estimates_its_steps() {
        let clock = Clock { step: 10, seconds: 2.0, ..Clock::default() };
        assert_eq!(clock.total_steps(TrainingBudget::Seconds(20.0), 1.0), 100.0);
        assert_eq!(clock.share(TrainingBudget::Seconds(20.0)), 0.1);
        assert_eq!(clock.remaining_seconds(TrainingBudget::Steps(20), 1.0), 2.0);
        assert_eq!(Clock::default().total_steps(TrainingBudget::Steps(5), 1.0), 5.0);
        assert_eq!(clock.total_steps(TrainingBudget::Steps(10), 1.0), 10.0);
        // Before the first step the pace is unknown: the warm-up takes its longest.
        let start = Clock::default().total_steps(TrainingBudget::Seconds(1.0), 1.0);
        assert!(crate::Schedule::WarmupCosine.factor(0, start) <= 1.0);
    }

    /// Steps of a second, then of a quarter.
    #[test]
    fn shares_of_a_time_budget_are_shares_of_the_steps() {
        let (budget, share) = (TrainingBudget::Seconds(40.0), 0.25);
        let mut clock = Clock::default();
        let mut estimates = Vec::new();
        while clock.share(budget) < 1.0 {
            if clock.rest.is_none() && clock.is_time_to_rest(budget, share) {
                clock.rest = Some((clock.step, clock.seconds));
            }
            let probing = clock.is_probing(budget, share);
            let seconds = if clock.rest.is_some() || probing { 0.25 } else { 1.0 };
            clock.count(seconds);
            clock.probe = if probing { Some(seconds) } else { clock.probe };
            estimates.push(clock.total_steps(budget, share));
        }
        // 0.25 n + 0.75 n / 4 = 40 with n = 91.4; one dear step more or less is worth four cheap ones.
        let (at_rest, _) = clock.rest.unwrap();
        assert!((22..=24).contains(&at_rest) && (88..=95).contains(&clock.step), "{clock:?}");
        assert!(estimates[3..].iter().all(|n| (n - 91.4).abs() < 4.0), "{estimates:?}");
    }
}
