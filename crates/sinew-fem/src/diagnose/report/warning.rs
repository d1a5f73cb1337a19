//! Warnings about a solution.

use super::SolutionReport;
use crate::{CellValue, LockingWarning};
use thiserror::Error;

/// Largest residual without a warning \[relative to the forces\]: six digits.
const LARGEST_RESIDUAL: f64 = 1e-6;
/// Least J without a warning: laws are seldom fitted below it.
const LEAST_VOLUME_RATIO: f64 = 0.3;
/// Largest J without a warning: tissue is mostly water.
const LARGEST_VOLUME_RATIO: f64 = 3.0;
/// Least mean ratio without a warning: gradients are poor in a tetrahedron with dihedral angles of a few degrees.
const LEAST_SHAPE: f64 = 0.1;

/// Reason to doubt a solution; its `Display` gives advice.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Warning {
    /// The residual is large.
    #[error(
        "the residual is {relative:.1e} of the forces; solve again from this displacement, or scale the units so \
         that forces are near 1"
    )]
    Residual { relative: f64 },
    /// The equilibrium is not a minimum.
    #[error(
        "the stiffness has {negative_pivots} negative pivots: the body would leave this equilibrium, but no force leads \
         away from it, as in a straight column beyond Euler's load; nudge it: solve_from this displacement plus a small \
         multiple of Solver::softest_mode, or load it by a prescribed motion"
    )]
    Unstable { negative_pivots: usize },
    /// The body is too large to count the negative eigenvalues of its stiffness.
    #[error(
        "the body is too large to count the negative eigenvalues of its stiffness; conjugate gradients met no negative curvature, as at \
         stable equilibria; Solver::softest_mode factorises the stiffness, in some gigabytes"
    )]
    NotCounted,
    /// A cell has lost most of its volume.
    #[error("J is only {worst}: reduce the load, stiffen the volume, or refine the mesh there")]
    Squeezed { worst: CellValue },
    /// A cell has grown to a multiple of its volume.
    #[error("J reaches {worst}: raise the bulk modulus, or reduce the load")]
    Swollen { worst: CellValue },
    /// A cell is nearly flat at rest.
    #[error(
        "the mesh has a cell of mean ratio {worst}: gradients there are poor; improve the mesh"
    )]
    PoorMesh { worst: CellValue },
    /// A cell has become nearly flat.
    #[error(
        "the deformation leaves a cell of mean ratio {worst}; start with cells that are stretched the other way, \
         or refine the mesh there"
    )]
    Distorted { worst: CellValue },
    /// The elements are too stiff.
    #[error("{0}")]
    Locking(LockingWarning),
}

/// All but locking.
pub(super) fn of(
    report: &SolutionReport,
    (negative_pivots, counted): (usize, bool),
) -> Vec<Warning> {
    let relative = report.relative_residual;
    let balanced = relative <= LARGEST_RESIDUAL;
    let swollen = report.largest_volume_ratio;
    let squeezed = report.least_volume_ratios.first().copied();
    let squeezed = squeezed.filter(|worst| worst.value < LEAST_VOLUME_RATIO);
    let [at_rest, deformed] = [&report.worst_reference_shapes, &report.worst_deformed_shapes]
        .map(|shapes| shapes.first().copied().filter(|shape| shape.value < LEAST_SHAPE));
    let found = [
        (!balanced).then_some(Warning::Residual { relative }),
        (negative_pivots > 0).then_some(Warning::Unstable { negative_pivots }),
        (negative_pivots == 0 && !counted).then_some(Warning::NotCounted),
        squeezed.map(|worst| Warning::Squeezed { worst }),
        (swollen.value > LARGEST_VOLUME_RATIO).then_some(Warning::Swollen { worst: swollen }),
        at_rest.map(|worst| Warning::PoorMesh { worst }),
        deformed.filter(|_| at_rest.is_none()).map(|worst| Warning::Distorted { worst }),
    ];
    found.into_iter().flatten().collect()
}
