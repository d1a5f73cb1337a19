//! Training: batches, steps, evaluations, checkpoints.

mod best;
mod checkpoint;
mod clock;
mod concern;
mod config;
mod diagnosis;
mod progress;
mod sampler;
mod trainer;

pub use concern::Concern;
pub use config::{TrainingBudget, TrainingConfig};
pub use progress::{HistoryPoint, TrainingObserver, TrainingProgress, TrainingReport};
pub use trainer::Trainer;
