//! Training: batches, steps, evaluations, checkpoints.

mod checkpoint;
mod clock;
mod config;
mod progress;
mod sampler;
mod trainer;

pub(crate) use config::scale;
pub use config::{Schedule, TrainingBudget, TrainingConfig};
pub use progress::{Concern, HistoryPoint, TrainingObserver, TrainingProgress, TrainingReport};
pub use trainer::Trainer;
