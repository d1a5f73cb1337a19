//! Reasons why there are no draws.

/// Why a density was not sampled, or chains not written: what is wrong, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SampleError(pub(crate) String);

impl SampleError {
    pub(crate) fn curvature(found: &str) -> Self {
        Self(format!(
            "the curvature at the mode is not positive definite: {found}; start from a mode, or add a prior on what the data leave open"
        ))
    }
}
