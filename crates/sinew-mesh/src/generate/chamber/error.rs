//! Errors of chamber walls, with places and advice.

use crate::Defect;
use thiserror::Error;

/// A point or direction as people read it.
pub(super) fn shown(point: impl Into<[f64; 3]>) -> String {
    let [x, y, z] = point.into();
    format!("({x:.3}, {y:.3}, {z:.3})")
}

/// Result of a step towards a wall.
pub(super) type Result<T, E = ChamberError> = std::result::Result<T, E>;

/// Why no wall can be made of surfaces, with places and advice. Points are in the surfaces' own unit of length.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct ChamberError(pub(super) String);

impl From<Defect> for ChamberError {
    fn from(defect: Defect) -> Self {
        Self(defect.to_string())
    }
}
