//! Muscle fibres of ventricles by rules: they turn with the depth in the wall.
//!
//! - [`VentricleCoordinates`] finds the depth in the wall and the way to the base by Laplace problems on any
//!   tetrahedral mesh whose surfaces are named, and from them a [`Frame`] per cell or per node.
//! - [`EllipsoidWall`] has both in closed form between two ellipsoids, at any point.
//! - [`FibreRule`] holds the angles.
//! - [`by_rule`] assigns fibres to a mesh in one call.
//!
//! # Fibres of files
//! A fibre has no sense: d and −d are the same. Nodal directions must therefore agree in sign before they are averaged;
//! lowering a [`sinew_energy::Scene`] aligns them cell by cell. A file whose directions were averaged without this has
//! wrong fibres: in the left ventricle published with the thesis 28 % of the cells (1742 of 6176 by more than 10°, 543
//! by more than 45°), which changes its displacement by 48 %. [`cells_of_mixed_signs`] counts the cells that such an
//! average affects.
//!
//! ```
//! use sinew_fem::fibres::{EllipsoidWall, FibreRule, Surfaces, VentricleCoordinates};
//! use sinew_mesh::TruncatedEllipsoid;
//!
//! let mesh = TruncatedEllipsoid::LAND.wall([2, 16, 8]).tetrahedra();
//! let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
//! let wall = VentricleCoordinates::new(&mesh, &surfaces)?;
//! let frames = wall.cell_frames(&FibreRule::SIXTY);
//!
//! // The directions that a law reads: `law.along(directions)` is the material of a Scene.
//! let directions: Vec<[[f64; 3]; 1]> = frames.iter().map(|&[fibre, _, _]| [fibre]).collect();
//! assert_eq!(directions.len(), mesh.cells.len());
//!
//! // The same wall in closed form: on the endocardium, fibres climb at 60 degrees.
//! let [fibre, _, _] = EllipsoidWall::LAND.frame([7.0, 0.0, 0.0], &FibreRule::SIXTY, 0.0)?;
//! assert!((fibre[2] - 60_f64.to_radians().sin()).abs() < 1e-12);
//! # Ok::<(), sinew_fem::fibres::FibreError>(())
//! ```

mod potential;
mod rule;
mod ventricle;

pub use rule::{EllipsoidWall, FibreError, FibreRule, Frame};
pub use ventricle::{Surfaces, VentricleCoordinates};

use rule::Result;
use sinew_mesh::TetMesh;
use sinew_num::dot3;

/// Fibre, sheet and normal at the centre of each cell of a ventricle, turned by a rule with the depth in its wall.
///
/// ```
/// use sinew_fem::fibres::{FibreRule, Surfaces, by_rule};
///
/// let mesh = sinew_mesh::TruncatedEllipsoid::LAND.wall([2, 16, 8]).tetrahedra();
/// let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
/// let frames = by_rule(&mesh, &surfaces, &FibreRule::SIXTY)?;
/// assert_eq!(frames.len(), mesh.cells.len());
/// # Ok::<(), sinew_fem::fibres::FibreError>(())
/// ```
///
/// # Errors
/// As for [`VentricleCoordinates::new`].
pub fn by_rule(mesh: &TetMesh, surfaces: &Surfaces<'_>, rule: &FibreRule) -> Result<Vec<Frame>> {
    Ok(VentricleCoordinates::new(mesh, surfaces)?.cell_frames(rule))
}

/// Number of cells whose nodal directions disagree in sign, so that their plain average is wrong.
///
/// ```
/// let cells = [[0, 1, 2, 3], [1, 2, 3, 4]];
/// let mut directions = [[1.0, 0.0, 0.0]; 5];
/// directions[0][0] = -1.0;
/// let cells = cells.iter().map(|nodes| &nodes[..]);
/// assert_eq!(sinew_fem::fibres::cells_of_mixed_signs(cells, &directions), 1);
/// ```
///
/// # Panics
/// Where a cell names a node without a direction.
pub fn cells_of_mixed_signs<'a>(
    cells: impl Iterator<Item = &'a [usize]>,
    directions: &[[f64; 3]],
) -> usize {
    let mixed = |nodes: &&[usize]| {
        nodes.iter().any(|&node| dot3(&directions[node], &directions[nodes[0]]) < 0.0)
    };
    cells.filter(mixed).count()
}
