//! Where a run stands in its budget.

use serde::{Deserialize, Serialize};

use super::config::Budget;

/// Steps made and seconds spent on them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Clock {
    pub step: usize,
    pub seconds: f64,
}

impl Clock {
    /// Share of the budget that is spent, from 0 to 1.
    pub fn share(&self, budget: Budget) -> f64 {
        let share = match budget {
            Budget::Steps(steps) => self.step as f64 / steps as f64,
            Budget::Seconds(seconds) => self.seconds / seconds,
        };
        share.min(1.0)
    }

    /// Steps of the whole run; under a time budget estimated from the pace so far, and at least one more.
    pub fn total_steps(&self, budget: Budget) -> f64 {
        match budget {
            Budget::Steps(steps) => steps as f64,
            Budget::Seconds(seconds) => {
                // Before the first step the pace is no number, and `max` gives the one step.
                (self.step as f64 * (seconds / self.seconds)).max(self.step as f64 + 1.0)
            }
        }
    }

    /// Seconds until the budget is spent, at the pace so far.
    pub fn remaining_seconds(&self, budget: Budget) -> f64 {
        match budget {
            Budget::Seconds(seconds) => (seconds - self.seconds).max(0.0),
            Budget::Steps(_) if self.step == 0 => f64::INFINITY,
            Budget::Steps(steps) => {
                self.seconds / self.step as f64 * steps.saturating_sub(self.step) as f64
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_budget_estimates_its_steps() {
        let clock = Clock { step: 10, seconds: 2.0 };
        assert_eq!(clock.total_steps(Budget::Seconds(20.0)), 100.0);
        assert_eq!(clock.share(Budget::Seconds(20.0)), 0.1);
        assert_eq!(clock.remaining_seconds(Budget::Steps(20)), 2.0);
        assert_eq!(Clock::default().total_steps(Budget::Steps(5)), 5.0);
        assert_eq!(clock.total_steps(Budget::Steps(10)), 10.0);
        // Before the first step the pace is unknown: the warm-up takes its longest.
        let start = Clock::default().total_steps(Budget::Seconds(1.0));
        assert!(crate::Schedule::WarmupCosine.factor(0, start) <= 1.0);
    }
}
