//! A budget, shared by the stages of a training.

use crate::training::{TrainingBudget as Length, TrainingConfig};
use sinew_emulate::Budget;

/// Scales the stages of a training to a budget. `spent` is the time that simulations took \[s\].
pub(crate) fn scale(stages: &mut [&mut TrainingConfig], budget: Budget, spent: f64) {
    let total: f64 = stages.iter().map(|stage| stage.cost()).sum();
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
                Length::Seconds(left * stage.cost() / total)
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
    if let Length::Steps(steps) = config.budget { steps as f64 } else { 0.0 }
}

impl TrainingConfig {
    /// Cost of the training in decoded parameter sets; 0 for a budget in seconds. Stages and recipes share a budget by it.
    pub fn cost(&self) -> f64 {
        let step = self.embedding_share * PASS_COST + DECODER_COST + self.batch as f64;
        step * steps_of(self)
    }
}
