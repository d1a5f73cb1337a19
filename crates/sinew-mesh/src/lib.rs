//! Simplex meshes.
mod check;
mod error;
mod field;
mod generate;
mod geometry;
mod io;
mod mesh;
mod topology;

pub use error::{Defect, MeshError, Place, Problem};
pub use generate::{box_tetrahedra, rectangle_triangles};
pub use geometry::repair_orientation;
pub use io::{
    AnyMesh, NpyArray, ReadReport, VtkEncoding, parse, parse_npy, parse_tet_mesh,
    parse_triangle_mesh, read, read_npy, read_tet_mesh, read_triangle_mesh, to_npy, to_pvd, to_vtk,
    to_vtu, write_npy, write_pvd, write_vtk, write_vtu,
};
pub use mesh::{Facet, Field, FieldValues, SimplexMesh, TetMesh, TriangleMesh};
pub use topology::{boundary_facets, edges, remove_unused_nodes};
