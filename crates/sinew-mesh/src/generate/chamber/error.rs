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
    /// Surfaces in different units.
    #[error(
        "the endocardium is {endocardium:.3} long and the epicardium {epicardium:.3}, a factor near {ratio} too far apart: the endocardium seems to \
         be in {}, the epicardium in {}; give both in one unit",
        units[0], units[1]
    )]
    Units { endocardium: f64, epicardium: f64, ratio: f64, units: [&'static str; 2] },
    /// One surface in the place of both.
    #[error(
        "the endocardium and the epicardium are the same surface: no point of one is farther than {distance:.1e} from the other; give two surfaces"
    )]
    Same { distance: f64 },
    /// Surfaces in the place of each other.
    #[error(
        "the epicardium, {epicardium:.3} long, lies inside of the endocardium, {endocardium:.3} long; give each in the place of the other"
    )]
    Swapped { endocardium: f64, epicardium: f64 },
    /// Surfaces that do not lie in each other.
    #[error(
        "{count} of {of} points of the endocardium lie outside of the epicardium, and the middles of the two are {shift:.3} apart; give both in one \
         frame of coordinates"
    )]
    Apart { count: usize, of: usize, shift: f64 },
    /// A surface of several pieces.
    #[error(
        "the {surface} has {pieces} pieces without a common point, the largest of {} triangles and the next of {} at {}; remove the pieces that do not \
         belong to it",
        triangles[0], triangles[1], shown(point)
    )]
    Pieces { surface: &'static str, pieces: usize, triangles: [usize; 2], point: [f64; 3] },
    /// A surface with holes.
    #[error(
        "the {surface} has {rims} rims, the longest of {} edges and the next of {} at {}, and no plane below the valves cuts a whole wall; close the \
         holes, or give the plane of the base: a point and a normal",
        edges[0], edges[1], shown(point)
    )]
    Rims { surface: &'static str, rims: usize, edges: [usize; 2], point: [f64; 3] },
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
