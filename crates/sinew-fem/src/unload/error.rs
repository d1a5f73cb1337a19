//! Errors of unloading, with numbers and advice.

use crate::{CellValue, SolveError};
use thiserror::Error;

/// Failure of unloading.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum UnloadError {
    /// A body or θ that makes no sense.
    #[error(transparent)]
    Body(#[from] SolveError),
    /// The mixed formulation.
    #[error(
        "a body with a field of pressure cannot be unloaded; lower it with averaged volume ratios (Scene::averaged) and a large bulk modulus"
    )]
    PressureField,
    /// A pressure's potential is counted from the plane that its rim slides in.
    #[error(
        "node {node} on the rim of a pressure slides along a plane that its support moves; prescribe no displacement there, or hold the node \
         along all axes"
    )]
    MovedRim { node: usize },
    /// No body at rest.
    #[error(
        "no unloaded configuration was found in {iterations} iterations: the image bears {part:.4} of the load, where cells at rest are \
         {least} to {largest} times as large; the load may be too large for this shape, or theta too soft: \
         check the units of pressure and stiffness, reduce the load, or stiffen the material"
    )]
    NotFound { part: f64, iterations: usize, least: CellValue, largest: CellValue },
    /// The body at rest passes through itself.
    #[error(
        "the unloaded body crosses itself: {pairs} pairs of triangles of its surface, the first at cells {} and {}; the material is too soft \
         for this load, or the load is too large",
        cells[0], cells[1]
    )]
    CrossesItself { pairs: usize, cells: [usize; 2] },
    /// The image is an unstable equilibrium.
    #[error(
        "the image is an unstable equilibrium of the unloaded body: its stiffness has {negative_pivots} negative eigenvalues; no such state can \
         have been seen, so theta or the load are not those of the image"
    )]
    Unstable { negative_pivots: usize },
    /// Loading leads elsewhere.
    #[error(
        "the unloaded body, loaded from rest, comes to another equilibrium: {distance:.3e} away from the image at node {node}; the image is on \
         a branch that a rising load does not lead to"
    )]
    OtherBranch { distance: f64, node: usize },
    /// Loading fails.
    #[error(
        "the image is a stable equilibrium of the unloaded body, but raising the load from rest does not reach it: {0}"
    )]
    NotLoaded(SolveError),
    /// A derivative that does not exist.
    #[error(
        "the positions at rest have no derivative in theta here (a limit point of unloading); move theta a little"
    )]
    Singular,
}
