//! Writing of CARP meshes.

use super::carp::{DIRECTIONS, ELEMENTS, PER_MM, REGION, with};
use crate::{Mesh, MeshError, Problem};
use std::fmt::Write;
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
    let kind = Mesh::<N>::ELEMENT;
    let word = |vtk: u8| ELEMENTS.iter().find(|(_, of, _)| *of == vtk).map(|(word, ..)| *word);
    let (Some(cell_word), Some(facet_word)) = (word(kind.vtk_type), word(kind.facet_vtk_type))
    else {
        let (what, value) = ("the kind of cell", kind.name.into());
        let advice = "CARP has linear cells only: write the mesh before it is made quadratic";
        return Err(MeshError::Cells(Box::new(Problem::Unsupported { what, value, advice })));
    };
    let save =
        |ending: &str, text: String| super::save(&with(stem.as_ref(), ending), text.as_bytes());
    let row = |numbers: &mut dyn Iterator<Item = f64>| {
        numbers.map(|x| x.to_string()).collect::<Vec<_>>().join(" ") + "\n"
    };
    let listed = |word: &str, nodes: &[usize]| {
        nodes.iter().fold(word.to_string(), |line, node| format!("{line} {node}"))
    };

    let mut points = format!("{}\n", mesh.points.len());
    points.extend(mesh.points.iter().map(|x| row(&mut x.iter().map(|x| x * PER_MM))));
    save("pts", points)?;

    let labels = mesh.cell_fields.get(REGION).and_then(|field| field.as_labels());
    let mut elements = format!("{}\n", mesh.cells.len());
    for (index, cell) in mesh.cells.iter().enumerate() {
        let mut nodes = cell.to_vec();
        if N == 8 {
            nodes.swap(5, 7);
        }
        elements += &listed(cell_word, &nodes);
        if let Some(labels) = labels {
            let _ = write!(elements, " {}", labels[index]);
        }
        elements.push('\n');
    }
    save("elem", elements)?;

    let directions =
        DIRECTIONS.iter().map_while(|name| mesh.cell_fields.get(*name)?.to_vectors::<3>());
    let directions: Vec<Vec<[f64; 3]>> = directions.collect();
    if !directions.is_empty() {
        let mut text = format!("{}\n", directions.len());
        let of_cell = |cell: usize| row(&mut directions.iter().flat_map(|rows| rows[cell]));
        text.extend((0..mesh.cells.len()).map(of_cell));
        save("lon", text)?;
    }
    for (name, facets) in mesh.facet_sets.iter().filter(|_| kind.dimension == 3) {
        let mut text = format!("{}\n", facets.len());
        for &facet in facets {
            text += &(listed(facet_word, &mesh.nodes_of_facet(facet).collect::<Vec<_>>()) + "\n");
        }
        save(&format!("{name}.surf"), text)?;
    }
    for (name, nodes) in &mesh.node_sets {
        let mut text = format!("{}\nextra\n", nodes.len());
        text.extend(nodes.iter().map(|node| format!("{node}\n")));
        save(&format!("{name}.vtx"), text)?;
    }
    Ok(())
}
