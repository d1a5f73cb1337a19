//! Settings of a training run.

use serde::{Deserialize, Serialize};

use crate::{Error, OptimiserConfig, Result, Schedule};
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
