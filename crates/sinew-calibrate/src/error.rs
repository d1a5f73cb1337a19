//! Errors of a patient, with numbers and advice.

use sinew_fem::fibres::FibreError;
use sinew_fem::{SolveError, UnloadError};
use thiserror::Error;

/// A patient that makes no sense.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PatientError {
    /// The body cannot be unloaded.
    #[error(transparent)]
    Unload(#[from] UnloadError),
    /// The body cannot be solved.
    #[error(transparent)]
    Body(#[from] SolveError),
    /// A name, number, segment or place of a patient that makes no sense, with advice.
    #[error("{0}")]
    Input(String),
    /// The wall has no coordinates.
    #[error(transparent)]
    Wall(#[from] FibreError),
}
