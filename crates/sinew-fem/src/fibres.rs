//! Muscle fibres of ventricles by rules: they turn with the depth in the wall.
//!
//! - [`VentricleCoordinates`] finds the depth in the wall and the way to the base by Laplace problems on any
//!   tetrahedral mesh whose surfaces are named, and from them a [`Frame`] per cell or per node.
//! - [`EllipsoidWall`] has both in closed form between two ellipsoids, at any point.
//! - [`FibreRule`] holds the angles.
//!
//! ```
//! use sinew_fem::fibres::{Depth, EllipsoidWall, FibreRule, Surfaces, VentricleCoordinates};
//! use sinew_mesh::TruncatedEllipsoid;
//!
//! let mesh = TruncatedEllipsoid::LAND.wall([2, 16, 8]).tetrahedra();
//! let surfaces = Surfaces { endocardium: "endo", epicardium: "epi", base: "base" };
//! let wall = VentricleCoordinates::new(&mesh, &surfaces)?;
//! let frames = wall.cell_frames(&FibreRule::SIXTY, Depth::Thickness);
//!
//! // The directions of a Scene whose law reads fibres.
//! let directions: Vec<[[f64; 3]; 1]> = frames.iter().map(|&[fibre, _, _]| [fibre]).collect();
//! assert_eq!(directions.len(), mesh.cells.len());
//!
//! // The same wall in closed form: on the endocardium, fibres climb at 60 degrees.
//! let [fibre, _, _] = EllipsoidWall::LAND.frame([7.0, 0.0, 0.0], &FibreRule::SIXTY, 0.0)?;
//! assert!((fibre[2] - 60_f64.to_radians().sin()).abs() < 1e-12);
//! # Ok::<(), sinew_fem::fibres::FibreError>(())
//! ```

mod ellipsoid;
mod error;
mod potential;
mod rule;
mod surfaces;
mod ventricle;

pub use ellipsoid::EllipsoidWall;
pub use error::FibreError;
pub use rule::{FibreRule, Frame};
pub use surfaces::Surfaces;
pub use ventricle::{Depth, VentricleCoordinates};
