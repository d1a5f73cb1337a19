//! Settings of a training run, its schedule, and its share of a budget.

use crate::{Error, OptimiserConfig, Result};
use serde::{Deserialize, Serialize};
use sinew_emulate::Budget;
use sinew_emulate::coordinates::require_positive;

/// Length of the training.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TrainingBudget {
    /// A number of steps: repeatable, and resumed exactly.
    Steps(usize),
    /// Seconds of training, evaluations not counted; schedules follow the steps that will have been made then.
    Seconds(f64),
}

/// Settings of a training run; the defaults are those of the physics-informed beams.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TrainingConfig {
    /// Rule of the weights' update.
    pub optimiser: OptimiserConfig,
    /// Peak of the learning rate.
    pub learning_rate: f64,
    /// Development of the learning rate.
    pub schedule: Schedule,
    /// Length of the training.
    pub budget: TrainingBudget,
    /// Parameter sets per step, all of one geometry; they share one message-passing pass.
    pub batch: usize,
    /// Largest Euclidean norm of all gradients together; larger ones are scaled down to it.
    pub gradient_norm_limit: Option<f64>,
    /// Share of the steps in which message passing is trained. From then on the embeddings of every geometry's nodes are
    /// weights of their own, trained with decoders and parameter encoder at a fraction of the cost; 1 trains message
    /// passing to the end. A network for unseen shapes needs 1 or a [frozen encoder](Self::frozen_encoder).
    pub embedding_share: f64,
    /// Whether the embeddings stay constant after that share of the steps instead of becoming weights: decoders and parameter encoder are
    /// trained on what message passing predicts, as they are used for unseen shapes. The embeddings of all geometries are held
    /// in memory, `2 M` numbers a node.
    #[doc(alias = "freeze")]
    pub frozen_encoder: bool,
    /// Seed of the order of the samples.
    pub seed: u64,
    /// Evaluations (validation, observer, checkpoint), evenly spread over the budget. The last one is at its end.
    pub evaluations: usize,
}

impl Default for TrainingConfig {
    fn default() -> Self {
        Self {
            optimiser: OptimiserConfig::default(),
            learning_rate: 4e-3,
            schedule: Schedule::default(),
            budget: TrainingBudget::Steps(4000),
            batch: 8,
            gradient_norm_limit: Some(1.0),
            embedding_share: 1.0,
            frozen_encoder: false,
            seed: 0,
            evaluations: 20,
        }
    }
}

impl TrainingConfig {
    /// Requires a positive batch, budget and learning rate.
    ///
    /// # Errors
    /// The first value that is not.
    pub fn check(&self) -> Result<()> {
        if self.batch == 0 {
            return Err(Error::Configuration { what: "batch", value: 0 });
        }
        match self.budget {
            TrainingBudget::Steps(0) => {
                return Err(Error::NothingToTrain("the budget is zero steps"));
            }
            TrainingBudget::Steps(_) => {}
            TrainingBudget::Seconds(seconds) => require_positive("the budget in seconds", seconds)?,
        }
        if let Some(limit) = self.gradient_norm_limit {
            require_positive("the limit of the gradient norm", limit)?;
        }
        if !(0.0..=1.0).contains(&self.embedding_share) {
            return Err(Error::EmbeddingShare(self.embedding_share));
        }
        Ok(require_positive("the learning rate", self.learning_rate)?)
    }
}

/// Development of the learning rate, as a factor of its peak.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// The peak throughout.
    Constant,
    /// Linear warm-up over 5 % of the steps but at most 200, then half a cosine down to 1e-3 of the peak.
    #[default]
    WarmupCosine,
}

/// Share of the steps spent on warm-up.
const WARMUP_SHARE: f64 = 0.05;
/// Longest warm-up, in steps.
const WARMUP_STEPS: f64 = 200.0;
/// Factor at the end of the cosine.
const COSINE_END: f64 = 1e-3;

impl Schedule {
    /// Factor of step `step` (from zero) of `total` steps. Under a time budget `total` is an estimate.
    pub(crate) fn factor(self, step: usize, total: f64) -> f64 {
        let step = step as f64;
        match self {
            Self::Constant => 1.0,
            Self::WarmupCosine => {
                let warmup = (WARMUP_SHARE * total).min(WARMUP_STEPS);
                if step < warmup {
                    return (step + 1.0) / (warmup + 1.0);
                }
                let share = ((step - warmup) / (total - warmup).max(1.0)).min(1.0);
                COSINE_END + (1.0 - COSINE_END) * 0.5 * (1.0 + (std::f64::consts::PI * share).cos())
            }
        }
    }
}

/// Scales the stages of a training to a budget. `spent` is the time that simulations took \[s\].
pub(crate) fn scale(stages: &mut [&mut TrainingConfig], budget: Budget, spent: f64) {
    let total: f64 = stages.iter().map(|stage| stage.cost()).sum();
    let steps: f64 = stages.iter().map(|stage| steps_of(stage)).sum();
    for stage in stages {
        let scaled = |factor: f64, stage: &TrainingConfig| {
            TrainingBudget::Steps(((steps_of(stage) * factor).round() as usize).max(1))
        };
        stage.budget = match budget {
            Budget::Effort(factor) => scaled(factor, stage),
            Budget::Steps(count) => scaled(count as f64 / steps, stage),
            Budget::Seconds(seconds) => {
                let left = (TRAINING_SHARE * (seconds - spent)).max(LEAST_TRAINING * seconds);
                TrainingBudget::Seconds(left * stage.cost() / total)
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
    if let TrainingBudget::Steps(steps) = config.budget { steps as f64 } else { 0.0 }
}

impl TrainingConfig {
    /// Cost of the training in decoded parameter sets; 0 for a budget in seconds. Stages and recipes share a budget by it.
    pub fn cost(&self) -> f64 {
        let step = self.embedding_share * PASS_COST + DECODER_COST + self.batch as f64;
        step * steps_of(self)
    }
}
