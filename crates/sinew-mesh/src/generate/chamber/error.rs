//! Errors of chamber walls, with places and advice.

use crate::Defect;
use thiserror::Error;

/// A point or direction as people read it.
pub(super) fn shown([x, y, z]: &[f64; 3]) -> String {
    format!("({x:.3}, {y:.3}, {z:.3})")
}

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
        shown(apex),
        shown(axis)
    )]
    NoBase { apex: [f64; 3], axis: [f64; 3] },
    /// A plane or fraction that makes no sense.
    #[error("{what}; give a fraction between 0 and 1, or a point and a normal of finite length")]
    Trim { what: String },
    /// A ray that leaves the cavity without meeting the endocardium.
    #[error(
        "the endocardium has a hole below the base: nothing lies from {} along {}; put the base \
         further down, or close the hole",
        shown(origin),
        shown(direction)
    )]
    Hole { origin: [f64; 3], direction: [f64; 3] },
    /// A ray that meets the endocardium more than once.
    #[error(
        "seen from its axis the endocardium lies behind itself at {}; smooth its folds and papillary muscles, or put \
         the base further down",
        shown(point)
    )]
    Folded { point: [f64; 3] },
    /// Much of the endocardium has no outer surface around it.
    #[error(
        "{count} of {of} nodes of the endocardium have no outer surface along their normal, the first at {}; give the \
         epicardium around it, in the same unit, and the septum if there is one",
        shown(point)
    )]
    NoOutside { count: usize, of: usize, point: [f64; 3] },
    /// The surfaces touch.
    #[error(
        "the wall has no thickness at {}; part the surfaces there, or put the base further down",
        shown(point)
    )]
    Touching { point: [f64; 3] },
    /// Sizes that give no mesh.
    #[error(
        "{what}; give 60 to 3000000 nodes, or a positive length of edges, and at least one layer"
    )]
    Size { what: String },
    /// A cell is inside out.
    #[error(
        "a cell is inside out at {}: the surfaces turn too sharply there for this size of cells; smooth them, choose \
         other cells, or put the base further down",
        shown(at)
    )]
    Inverted { at: [f64; 3] },
}
