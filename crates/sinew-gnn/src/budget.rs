//! A budget, shared by the stages of a training.

use crate::training::{TrainingBudget as Length, TrainingConfig};
use sinew_emulate::Budget;

/// Scales the stages of a training to a budget. `spent` is the time that simulations took \[s\].
pub(crate) fn scale(stages: &mut [&mut TrainingConfig], budget: Budget, spent: f64) {
    let total: f64 = stages.iter().map(|stage| cost(stage)).sum();
    let steps: f64 = stages.iter().map(|stage| steps_of(stage)).sum();
    for stage in stages {
        let scaled = |factor: f64, stage: &TrainingConfig| {
            Length::Steps(((steps_of(stage) * factor).round() as usize).max(1))
        };
        stage.budget = match budget {
            Budget::Effort(factor) => scaled(factor, stage),
            Budget::Steps(count) => scaled(count as f64 / steps, stage),
            Budget::Seconds(seconds) => {
                let left = (TRAINING_SHARE * (seconds - spent)).max(LEAST_TRAINING * seconds);
                Length::Seconds(left * cost(stage) / total)
            }
        };
    }
}

/// Share of the time budget left after simulations that training may use. The rest is for evaluations.
const TRAINING_SHARE: f64 = 0.95;
/// Share of a time budget that training uses at least.
const LEAST_TRAINING: f64 = 0.2;
/// Cost of a message-passing pass with its update, and of a decoder update [decoded parameter sets]. On the thesis' beams a
/// step with eight parameter sets takes 120 ms. Without message passing it takes 14.5 ms, or 23 ms with 32 sets.
const PASS_COST: f64 = 300.0;
const DECODER_COST: f64 = 33.0;

fn steps_of(config: &TrainingConfig) -> f64 {
    match config.budget {
        Length::Steps(steps) => steps as f64,
        Length::Seconds(_) => 0.0,
    }
}

/// Cost of a training in decoded parameter sets.
pub(crate) fn cost(config: &TrainingConfig) -> f64 {
    let step = config.embedding_share * PASS_COST + DECODER_COST + config.batch as f64;
    step * steps_of(config)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stages() -> [TrainingConfig; 2] {
        let config = |steps, batch| TrainingConfig {
            budget: Length::Steps(steps),
            batch,
            ..TrainingConfig::default()
        };
        [config(500, 4), config(1500, 4)]
    }

    fn scaled(budget: Budget, spent: f64) -> [Length; 2] {
        let [mut first, mut second] = stages();
        scale(&mut [&mut first, &mut second], budget, spent);
        [first.budget, second.budget]
    }

    #[test]
    fn a_budget_is_split_over_the_stages() {
        assert_eq!(scaled(Budget::Effort(0.5), 0.0), [Length::Steps(250), Length::Steps(750)]);
        assert_eq!(scaled(Budget::Steps(400), 0.0), [Length::Steps(100), Length::Steps(300)]);
        let seconds = |spent| {
            scaled(Budget::Seconds(100.0), spent).map(|length| match length {
                Length::Seconds(seconds) => seconds,
                Length::Steps(_) => f64::NAN,
            })
        };
        let [first, second] = seconds(20.0);
        assert!((first - 19.0).abs() < 1e-9 && (second - 57.0).abs() < 1e-9, "{first} {second}");
        // Simulations that ate the budget leave some for training all the same.
        assert!((seconds(1000.0).iter().sum::<f64>() - 20.0).abs() < 1e-9);
    }
}
