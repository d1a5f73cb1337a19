//! Writing surfaces: VTP, STL and OBJ.

use super::vtu_write::{SURFACE, to_xml};
use crate::{MeshError, TriangleMesh};
use std::fmt::Write as _;

/// A surface as a VTP file; its sets are written as fields, see the crate's page.
///
/// # Errors
/// When the mesh breaks a rule of [`crate::Mesh::check`] or a name cannot be written.
pub fn to_vtp(mesh: &TriangleMesh) -> Result<Vec<u8>, MeshError> {
    to_xml(mesh, SURFACE, &[])
}

/// A surface as a binary STL file, which keeps the triangles only: no fields and sets, and coordinates in single precision.
///
/// # Errors
/// When the mesh breaks a rule of [`crate::Mesh::check`].
pub fn to_stl(mesh: &TriangleMesh) -> Result<Vec<u8>, MeshError> {
    mesh.check()?;
    let normal = |cell: usize| {
        let [a, b, c] = mesh.corners(cell);
        (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default()
    };
    let mut bytes = format!("{:<80}", "triangles of a sinew mesh").into_bytes();
    bytes.extend((mesh.cells.len() as u32).to_le_bytes());
    for cell in 0..mesh.cells.len() {
        let rows = [normal(cell)].into_iter().chain(mesh.corners(cell));
        bytes.extend(rows.flat_map(<[f64; 3]>::from).flat_map(|x| (x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    Ok(bytes)
}

/// A surface as an OBJ file, which keeps points and triangles bit for bit, but no fields and sets.
///
/// # Errors
/// When the mesh breaks a rule of [`crate::Mesh::check`].
pub fn to_obj(mesh: &TriangleMesh) -> Result<Vec<u8>, MeshError> {
    mesh.check()?;
    let mut text = String::from("# sinew mesh\n");
    for [x, y, z] in &mesh.points {
        let _ = writeln!(text, "v {x:?} {y:?} {z:?}");
    }
    for [a, b, c] in mesh.cells.iter().map(|cell| cell.map(|node| node + 1)) {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    Ok(text.into_bytes())
}
