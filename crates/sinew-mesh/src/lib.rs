//! Simplex meshes.
mod mesh;
pub use mesh::{Facet, Field, FieldValues, SimplexMesh, TetMesh, TriangleMesh};
