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

pub(crate) type Result<T, E = PatientError> = std::result::Result<T, E>;

/// Refuses a direction without length.
pub(crate) fn check_direction(direction: [f64; 3]) -> Result<()> {
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() {
        return Ok(());
    }
    let [x, y, z] = direction;
    Err(PatientError::Input(format!(
        "({x}, {y}, {z}) is no direction; give a vector of finite length"
    )))
}
