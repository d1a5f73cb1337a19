//! Errors of a patient, with numbers and advice.

use sinew_energy::listed;
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

/// Requires that input makes sense; `reason` says why it does not.
pub(crate) fn require(makes_sense: bool, reason: impl FnOnce() -> String) -> Result<()> {
    if makes_sense { Ok(()) } else { Err(PatientError::Input(reason())) }
}

/// Place of a name among those there are, which the error lists behind the `fault`.
pub(crate) fn place_of(
    name: &str,
    names: &[impl AsRef<str> + ToString],
    fault: impl FnOnce() -> String,
) -> Result<usize> {
    let place = names.iter().position(|other| other.as_ref() == name);
    place.ok_or_else(|| PatientError::Input(format!("{} {}", fault(), listed(names))))
}

/// Length of a direction, which must have one.
pub(crate) fn length_of(direction: [f64; 3]) -> Result<f64> {
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [x, y, z] = direction;
    let fault = || format!("({x}, {y}, {z}) is no direction; give a vector of finite length");
    require(length > 0.0 && length.is_finite(), fault).map(|()| length)
}
