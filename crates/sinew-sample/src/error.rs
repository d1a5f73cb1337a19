//! Reasons why there are no draws.

use std::path::PathBuf;

/// Reason why a density was not sampled, or chains not written.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum SampleError {
    /// The density has no curvature to whiten by.
    #[error(
        "the curvature at the mode is not positive definite: {0}; start from a mode, or add a prior on what the data leave open"
    )]
    Curvature(String),
    /// The density is not finite where a chain starts.
    #[error(
        "the density is not finite at the start of chain {0}; start from a point inside its domain"
    )]
    Start(usize),
    /// The sampler gave up.
    #[error("the No-U-Turn sampler cannot go on: {0}")]
    Stopped(String),
    /// Lists of different lengths.
    #[error("{what}: {found} where {expected} belong")]
    Length { what: String, found: usize, expected: usize },
    /// A file that cannot be written.
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
}
