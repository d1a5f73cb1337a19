//! Reading and writing mesh files.

mod convert;
mod cursor;
mod gmsh;
mod gmsh2;
mod gmsh4;
mod grid;
mod npy;
mod number;
mod obj;
mod polydata;
mod sets;
mod stl;
mod surface_write;
mod vtk;
mod vtk_write;
mod vtu;
mod vtu_data;
mod vtu_write;

use std::path::Path;

pub use convert::ReadReport;
pub use npy::{NpyArray, parse_npy, to_npy};
pub use surface_write::{to_obj, to_stl, to_vtk_surface, to_vtp};
pub use vtk_write::{VtkEncoding, to_vtk};
pub use vtu_write::{to_pvd, to_vtu};

use crate::{AnyMesh, Element, Mesh, MeshError, Problem, TetMesh, TriangleMesh};
use grid::UnstructuredGrid;

/// Reads a mesh from a legacy VTK, VTU, VTP, gmsh MSH, STL or OBJ file, which is told by its content, as is the kind of cell:
/// the first of quadratic tetrahedra, hexahedra, tetrahedra, quadratic triangles and triangles that it has.
///
/// # Errors
/// [`MeshError::File`] when the file cannot be read, [`MeshError::Content`] with the place and
/// the reason when its content cannot.
pub fn read(path: impl AsRef<Path>) -> Result<(AnyMesh, ReadReport), MeshError> {
    let (name, bytes) = load(path.as_ref())?;
    parse(&name, &bytes)
}

/// Reads a tetrahedral mesh; see [`read`].
///
/// # Errors
/// As [`read`], and when the file has other cells than tetrahedra, triangles, lines and points.
pub fn read_tet_mesh(path: impl AsRef<Path>) -> Result<(TetMesh, ReadReport), MeshError> {
    let (name, bytes) = load(path.as_ref())?;
    parse_tet_mesh(&name, &bytes)
}

/// Reads a triangle mesh; see [`read`].
///
/// # Errors
/// As [`read`], and when the file has other cells than triangles, lines and points.
pub fn read_triangle_mesh(path: impl AsRef<Path>) -> Result<(TriangleMesh, ReadReport), MeshError> {
    let (name, bytes) = load(path.as_ref())?;
    parse_triangle_mesh(&name, &bytes)
}

/// Reads a mesh of a known kind of cell, such as a [`crate::QuadraticTetMesh`] or a
/// [`crate::HexMesh`]; see [`read`].
///
/// # Errors
/// As [`read`], and when the file has cells of that dimension or higher of another kind.
///
/// ```no_run
/// let (ventricle, _) = sinew_mesh::read_mesh::<10>("ventricle.vtu")?;
/// let nodes_of_first_cell: [usize; 10] = ventricle.cells[0];
/// # Ok::<(), sinew_mesh::MeshError>(())
/// ```
pub fn read_mesh<const N: usize>(
    path: impl AsRef<Path>,
) -> Result<(Mesh<N>, ReadReport), MeshError> {
    let (name, bytes) = load(path.as_ref())?;
    parse_mesh(&name, &bytes)
}

/// Reads the bytes of a mesh file; `file` is its name for errors. See [`read`].
///
/// # Errors
/// [`MeshError::Content`] with the place and the reason.
pub fn parse(file: &str, bytes: &[u8]) -> Result<(AnyMesh, ReadReport), MeshError> {
    fn of<const N: usize>(
        file: &str,
        grid: UnstructuredGrid,
    ) -> Result<(AnyMesh, ReadReport), MeshError>
    where
        AnyMesh: From<Mesh<N>>,
    {
        let (mesh, report) = convert::to_mesh::<N>(file, grid)?;
        Ok((mesh.into(), report))
    }
    let grid = parse_grid(file, bytes)?;
    let has = |nodes| grid.types.contains(&Element::with_nodes(nodes).vtk_type);
    // A file without any of them is refused as one of tetrahedra.
    match [10, 8, 4, 6, 3].into_iter().find(|&nodes| has(nodes)) {
        Some(10) => of::<10>(file, grid),
        Some(8) => of::<8>(file, grid),
        Some(6) => of::<6>(file, grid),
        Some(3) => of::<3>(file, grid),
        _ => of::<4>(file, grid),
    }
}

/// Reads the bytes of a tetrahedral mesh file; see [`read_tet_mesh`].
///
/// # Errors
/// [`MeshError::Content`] with the place and the reason.
pub fn parse_tet_mesh(file: &str, bytes: &[u8]) -> Result<(TetMesh, ReadReport), MeshError> {
    convert::to_mesh(file, parse_grid(file, bytes)?)
}

/// Reads the bytes of a triangle mesh file; see [`read_triangle_mesh`].
///
/// # Errors
/// [`MeshError::Content`] with the place and the reason.
pub fn parse_triangle_mesh(
    file: &str,
    bytes: &[u8],
) -> Result<(TriangleMesh, ReadReport), MeshError> {
    convert::to_mesh(file, parse_grid(file, bytes)?)
}

/// Reads the bytes of a mesh file with a known kind of cell; see [`read_mesh`].
///
/// # Errors
/// [`MeshError::Content`] with the place and the reason.
pub fn parse_mesh<const N: usize>(
    file: &str,
    bytes: &[u8],
) -> Result<(Mesh<N>, ReadReport), MeshError> {
    convert::to_mesh(file, parse_grid(file, bytes)?)
}

/// Reads an npy array; see [`parse_npy`].
///
/// # Errors
/// [`MeshError::File`] when the file cannot be read, [`MeshError::Content`] when its content
/// cannot.
pub fn read_npy(path: impl AsRef<Path>) -> Result<NpyArray, MeshError> {
    let (name, bytes) = load(path.as_ref())?;
    parse_npy(&name, &bytes)
}

/// Writes a legacy VTK file; see [`to_vtk`].
///
/// # Errors
/// As [`to_vtk`], and when the file cannot be written.
pub fn write_vtk<const N: usize>(
    path: impl AsRef<Path>,
    mesh: &Mesh<N>,
    encoding: VtkEncoding,
) -> Result<(), MeshError> {
    save(path.as_ref(), &to_vtk(mesh, encoding)?)
}

/// Writes a VTU file; see [`to_vtu`].
///
/// # Errors
/// As [`to_vtu`], and when the file cannot be written.
pub fn write_vtu<const N: usize>(path: impl AsRef<Path>, mesh: &Mesh<N>) -> Result<(), MeshError> {
    save(path.as_ref(), &to_vtu(mesh)?)
}

/// Writes a surface in the format that the ending of the name says: `vtk` (POLYDATA) and `stl` in binary, `vtp`, `obj`.
///
/// # Errors
/// As [`to_vtk_surface`], on another ending, and when the file cannot be written.
pub fn write_surface(path: impl AsRef<Path>, mesh: &TriangleMesh) -> Result<(), MeshError> {
    let path = path.as_ref();
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let bytes = match ending.as_str() {
        "vtk" => to_vtk_surface(mesh, VtkEncoding::Binary)?,
        "vtp" => to_vtp(mesh)?,
        "stl" => to_stl(mesh, VtkEncoding::Binary)?,
        "obj" => to_obj(mesh)?,
        _ => {
            let advice = "name the file .vtk, .vtp, .stl or .obj";
            let value = ending.clone();
            let problem =
                Problem::Unsupported { what: "the ending of a surface's file,", value, advice };
            return Err(cursor::error_at(&path.display().to_string(), 0, problem));
        }
    };
    save(path, &bytes)
}

/// Writes a PVD file; see [`to_pvd`].
///
/// # Errors
/// As [`to_pvd`], and when the file cannot be written.
pub fn write_pvd(path: impl AsRef<Path>, series: &[(f64, &Path)]) -> Result<(), MeshError> {
    save(path.as_ref(), to_pvd(series)?.as_bytes())
}

/// Writes an npy array of 64-bit floats; see [`to_npy`].
///
/// # Errors
/// When the file cannot be written.
///
/// # Panics
/// When the number of values is not the product of the shape.
pub fn write_npy(path: impl AsRef<Path>, shape: &[usize], values: &[f64]) -> Result<(), MeshError> {
    save(path.as_ref(), &to_npy(shape, values))
}

/// Picks the reader by the first bytes, which are surer than the ending of a name.
fn parse_grid(file: &str, bytes: &[u8]) -> Result<UnstructuredGrid, MeshError> {
    let content = cursor::without_mark(bytes).trim_ascii_start();
    match content {
        [b'$', ..] => gmsh::parse(file, bytes),
        [b'<', ..] => vtu::parse(file, bytes),
        _ if content.starts_with(vtk::MAGIC) => vtk::parse(file, bytes),
        _ if stl::is_binary(bytes) || stl::is_text(content) => stl::parse(file, bytes),
        _ if obj::looks_like_it(content) => obj::parse(file, bytes),
        // Binary STL of another length than it declares is told by its name only.
        _ if file.to_ascii_lowercase().ends_with(".stl") => stl::parse(file, bytes),
        _ => Err(cursor::error_at(file, 0, Problem::UnknownFormat)),
    }
}

fn load(path: &Path) -> Result<(String, Vec<u8>), MeshError> {
    let failed = |source| MeshError::File { path: path.into(), source };
    Ok((path.display().to_string(), std::fs::read(path).map_err(failed)?))
}

fn save(path: &Path, bytes: &[u8]) -> Result<(), MeshError> {
    let failed = |source| MeshError::File { path: path.into(), source };
    std::fs::write(path, bytes).map_err(failed)
}
