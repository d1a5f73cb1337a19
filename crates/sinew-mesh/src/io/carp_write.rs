//! Writing of CARP meshes.

use super::carp::{DIRECTIONS, PER_MM, REGION, with};
use crate::{Mesh, MeshError, Problem};
use std::fmt::Display;
use std::path::Path;

/// Writes the files of a CARP mesh, whose path is given without ending: `.pts` in µm, of a mesh in mm, and `.elem` with the labels
/// of the integer cell field `region`. The cell fields `fibre` and `sheet` go to `.lon`, facet sets of solids to `.NAME.surf`, node
/// sets to `.NAME.vtx`. Other fields and cell sets have no place in them.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let beam = sinew_mesh::box_tetrahedra([4.0, 1.0, 1.0], [4, 1, 1]);
/// let path = folder.path().join("beam");
/// sinew_mesh::write_carp(&path, &beam)?;
/// let (again, report) = sinew_mesh::read_mesh::<4>(&path)?;
/// assert_eq!((again, report.in_micrometres), (beam, true));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Quadratic cells, of which CARP has none; a mesh that violates [`Mesh::check`]; files that cannot be written.
pub fn write_carp<const N: usize>(stem: impl AsRef<Path>, mesh: &Mesh<N>) -> Result<(), MeshError> {
    mesh.check()?;
    let (word, facet_word) = match N {
        3 => ("Tr ", "Ln "),
        4 => ("Tt ", "Tr "),
        8 => ("Hx ", "Qd "),
        _ => {
            let (what, kind) = ("the kind of cell", Mesh::<N>::ELEMENT.name);
            let advice = "CARP has linear cells only: write the mesh before it is made quadratic";
            return Err(MeshError::Cells(Box::new(Problem::unsupported(what, kind, advice))));
        }
    };
    let file = |ending: &str| with(stem.as_ref(), ending);
    let points = mesh.points.iter().map(|x| x.map(|x| x * PER_MM).to_vec());
    save(&file("pts"), mesh.points.len(), "", points)?;
    let labels = mesh.cell_fields.get(REGION).and_then(|field| field.as_labels());
    let elements = mesh.cells.iter().enumerate().map(|(index, cell)| {
        let mut row: Vec<i64> = cell.iter().map(|&node| node as i64).collect();
        if N == 8 {
            row.swap(5, 7);
        }
        row.extend(labels.map(|labels| labels[index]));
        row
    });
    save(&file("elem"), mesh.cells.len(), word, elements)?;
    let fields = DIRECTIONS.map(|name| mesh.cell_fields.get(name)?.to_vectors::<3>());
    let columns: Vec<_> = fields.into_iter().map_while(|column| column).collect();
    let rows = (0..mesh.cells.len()).map(|cell| columns.iter().flat_map(|c| c[cell]).collect());
    if !columns.is_empty() {
        save::<f64>(&file("lon"), columns.len(), "", rows)?;
    }
    for (name, facets) in mesh.facet_sets.iter().filter(|_| N > 3) {
        let rows = facets.iter().map(|&facet| mesh.nodes_of_facet(facet).collect());
        save(&file(&format!("{name}.surf")), facets.len(), facet_word, rows)?;
    }
    for (name, nodes) in &mesh.node_sets {
        let rows = nodes.iter().map(|&node| vec![node]);
        save(&file(&format!("{name}.vtx")), format!("{}\nextra", nodes.len()), "", rows)?;
    }
    Ok(())
}

/// Writes a number, and a line with a word and numbers for each row.
fn save<T: ToString>(
    path: &Path,
    number: impl Display,
    word: &str,
    rows: impl Iterator<Item = Vec<T>>,
) -> Result<(), MeshError> {
    let joined = |row: Vec<T>| row.iter().map(T::to_string).collect::<Vec<_>>().join(" ");
    let rows: String = rows.map(|row| format!("{word}{}\n", joined(row))).collect();
    super::files::save(path, format!("{number}\n{rows}").as_bytes())
}
