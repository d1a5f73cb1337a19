//! Simplex meshes.
mod generate;
mod geometry;
mod mesh;
mod topology;

pub use generate::{box_tetrahedra, rectangle_triangles};
pub use geometry::repair_orientation;
pub use mesh::{Facet, Field, FieldValues, SimplexMesh, TetMesh, TriangleMesh};
pub use topology::{boundary_facets, edges};
