//! Faults of a training that did not diverge, in words.

use serde::{Deserialize, Serialize};

/// A reason not to trust the weights that a training leaves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
#[serde(rename_all = "kebab-case")]
pub enum Concern {
    /// The loss is not below that of zero outputs, which are one displacement for all parameters, or the Taylor polynomial.
    #[error(
        "nothing was learned: the mean loss is {loss:.3e}, that without the network's outputs {of_zero_output:.3e}; train \
         for longer, or choose another recipe"
    )]
    NothingLearned { loss: f64, of_zero_output: f64 },
    /// The loss rose by more than half of its earlier reduction.
    #[error(
        "the mean loss rose from {lowest:.3e} at step {step} to {loss:.3e}; train for longer, or choose another recipe"
    )]
    LossRose { lowest: f64, step: usize, loss: f64 },
    /// Predictions that invert a cell, or whose energy only barriers bound.
    #[error(
        "{inadmissible} of {samples} predictions at the parameters of the training invert a cell, or stretch it so far \
         that only barriers bound its energy; train for longer, narrow the ranges of the parameters, or choose another \
         recipe"
    )]
    Inadmissible { inadmissible: usize, samples: usize },
}
