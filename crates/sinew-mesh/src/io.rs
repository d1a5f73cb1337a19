//! Reading and writing mesh files.

mod carp;
mod convert;
mod cursor;
mod foreign;
mod gmsh;
mod grid;
mod inp;
mod inp_elements;
mod inp_lines;
mod npy;
mod number;
mod polydata;
mod sets;
mod stl;
mod vtk;
mod vtu;
mod vtu_data;
mod write;

use std::path::Path;

pub use convert::ReadReport;
pub(crate) use cursor::save;
pub use cursor::text_of;
pub use grid::MixedMesh;
pub use npy::{NpyArray, parse_npy, to_npy, to_npy_of};
pub(crate) use write::to_xml;
pub use write::{DISPLACEMENT, to_vtu, write_pvd};

use crate::{AnyMesh, Element, Mesh, MeshError, Place, Refusal};
use cursor::{Fault, load};

/// Reads a mesh from a legacy VTK, VTU, VTP, gmsh MSH, STL, Abaqus or CalculiX input file, or from the files of a CARP mesh.
/// The content decides the format and the kind of cell: the first that the file has of quadratic tetrahedra, hexahedra, tetrahedra,
/// quadratic triangles and triangles. CARP meshes are told by the name: `heart.pts`, `heart.elem`, or `heart` alone.
///
/// # Errors
/// [`MeshError::File`] when the file cannot be read, [`MeshError::Content`] with the place and
/// the reason when its content cannot.
pub fn read(path: impl AsRef<Path>) -> Result<(AnyMesh, ReadReport), MeshError> {
    let (name, grid) = open(path.as_ref())?;
    to_any(grid).map_err(|fault| MeshError::in_file(&name, fault))
}

/// Reads a mesh as [`read`] does, and makes one node of those at the same place, within [`crate::SELECTION_TOLERANCE`]: the first,
/// in the sets of the others, with the fields of another where its own are zero.
///
/// # Errors
/// As [`read`].
pub fn read_merged(path: impl AsRef<Path>) -> Result<(AnyMesh, ReadReport), MeshError> {
    let (name, grid) = open(path.as_ref())?;
    let merged = to_any(MixedMesh { merge: true, ..grid });
    merged.map_err(|fault| MeshError::in_file(&name, fault))
}

/// Reads a mesh of cells with `N` nodes: 4 of tetrahedra, 3 of triangles, 10 and 6 of quadratic ones, 8 of hexahedra;
/// see [`read`].
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
    let (name, grid) = open(path.as_ref())?;
    convert::to_mesh(grid).map_err(|fault| MeshError::in_file(&name, fault))
}

/// Reads the bytes of a mesh file; `file` is its name for errors. See [`read`], which alone reads CARP meshes of several files.
///
/// # Errors
/// [`MeshError::Content`] with the place and the reason.
pub fn parse(file: &str, bytes: &[u8]) -> Result<(AnyMesh, ReadReport), MeshError> {
    parse_grid(file, bytes).and_then(to_any).map_err(|fault| MeshError::in_file(file, fault))
}

/// Reads the bytes of a mesh file with a known kind of cell; see [`read_mesh`].
///
/// # Errors
/// [`MeshError::Content`] with the place and the reason.
pub fn parse_mesh<const N: usize>(
    file: &str,
    bytes: &[u8],
) -> Result<(Mesh<N>, ReadReport), MeshError> {
    let mesh = parse_grid(file, bytes).and_then(convert::to_mesh);
    mesh.map_err(|fault| MeshError::in_file(file, fault))
}

/// Makes a mesh of the first kind of cell that a grid has: quadratic tetrahedra, hexahedra, tetrahedra, quadratic triangles,
/// triangles.
fn to_any(mut grid: MixedMesh) -> Result<(AnyMesh, ReadReport), Fault> {
    grid.rename_equal_cells();
    let has = |nodes| grid.types.contains(&Element::with_nodes(nodes).vtk_type);
    // A grid without any of them is refused as one of tetrahedra.
    match [10, 8, 4, 6, 3].into_iter().find(|&nodes| has(nodes)) {
        Some(10) => convert::to_mesh::<10>(grid).map(any),
        Some(8) => convert::to_mesh::<8>(grid).map(any),
        Some(6) => convert::to_mesh::<6>(grid).map(any),
        Some(3) => convert::to_mesh::<3>(grid).map(any),
        _ => convert::to_mesh::<4>(grid).map(any),
    }
}

fn any<M: Into<AnyMesh>>((mesh, report): (M, ReadReport)) -> (AnyMesh, ReadReport) {
    (mesh.into(), report)
}

impl MixedMesh {
    /// The mesh, as the readers of files make it, and what was changed for it.
    ///
    /// # Errors
    /// Points that are not finite, nodes that do not exist, cells of an unsupported kind, fields of the wrong length,
    /// sets of nodes that do not exist.
    pub fn into_mesh(self) -> Result<(AnyMesh, ReadReport), MeshError> {
        let (mesh, report) = to_any(self).map_err(|(_, problem)| MeshError::Refused(problem))?;
        // Readers check the sets of a file; these are unchecked.
        mesh.check()?;
        Ok((mesh, report))
    }
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

/// Writes a VTU file; see [`to_vtu`].
///
/// # Errors
/// As [`to_vtu`], and when the file cannot be written.
pub fn write_vtu<const N: usize>(path: impl AsRef<Path>, mesh: &Mesh<N>) -> Result<(), MeshError> {
    save(path.as_ref(), &to_vtu(mesh)?)
}

/// The content of a file, or of the files of a CARP mesh, and the name for errors about its cells.
fn open(path: &Path) -> Result<(String, MixedMesh), MeshError> {
    if let Some(stem) = carp::stem(path) {
        return carp::read(&stem);
    }
    let (name, bytes) = load(path)?;
    let grid = parse_grid(&name, &bytes).map_err(|fault| MeshError::in_file(&name, fault))?;
    Ok((name, grid))
}

const UNKNOWN_FORMAT: &str = "this is neither legacy VTK, VTU, VTP, gmsh MSH, Abaqus or CalculiX input (.inp), STL nor CARP \
     (.pts with .elem); convert the mesh to one of them, for example with `meshio convert`";

/// Picks the reader by the first bytes, which are more reliable than a file name.
fn parse_grid(file: &str, bytes: &[u8]) -> Result<MixedMesh, Fault> {
    let content = cursor::without_mark(bytes).trim_ascii_start();
    if let Some((format, advice)) = foreign::format(content) {
        return Err((Place::default(), Refusal::unsupported("the format", format, advice)));
    }
    match content {
        [b'$', ..] => gmsh::parse(bytes),
        [b'<', ..] if content.windows(8).any(|word| word == b"<VTKFile") => vtu::parse(bytes),
        _ if content.starts_with(vtk::MAGIC) => vtk::parse(bytes),
        _ if stl::is_binary(bytes) || stl::is_text(content) => stl::parse(bytes),
        // A keyword or a comment.
        [b'*', next, ..] if *next == b'*' || next.is_ascii_alphabetic() => inp::parse(bytes),
        // Binary STL with a wrong length is recognised by its name only.
        _ if file.to_ascii_lowercase().ends_with(".stl") => stl::parse(bytes),
        _ => Err((Place::default(), Refusal(UNKNOWN_FORMAT.into()))),
    }
}
