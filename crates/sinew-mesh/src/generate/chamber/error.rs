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

/// Surfaces that no wall can be made from. Points are in the surfaces' own unit of length.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ChamberError {
    /// A surface breaks a rule of every mesh.
    #[error(transparent)]
    Mesh(#[from] Defect),
    /// A surface without triangles.
    #[error("a surface has no triangles; give an endocardium and an epicardium")]
    Empty,
    /// A closed endocardium.
    #[error(
        "the endocardium is closed, so nothing says where its base is; give the plane of the base: a point and a normal"
    )]
    Closed,
    /// No plane is a base.
    #[error(
        "no plane across the axis from {} along {} cuts a whole wall below the valves; give the plane of the base: \
         a point and a normal",
        shown(*apex),
        shown(*axis)
    )]
    NoBase { apex: [f64; 3], axis: [f64; 3] },
    /// Surfaces, a base or sizes that give no wall.
    #[error("{0}")]
    Surfaces(String),
}
