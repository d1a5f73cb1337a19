//! VTK's surfaces: vertices, lines, polygons and strips, in legacy files (POLYDATA) and in XML (VTP).

use super::cursor::Result;
use super::grid::MixedMesh;
use crate::{Place, Refusal};

/// Triangles that a polygon or strip with fields may have on average: each repeats the fields' rows, so that a small file
/// could otherwise ask for much memory.
const MOST_REPEATED: usize = 64;

/// Cells as the nodes of all of them and where those of each begin.
pub(crate) struct CellList {
    /// The nodes of cell `c` stand in `nodes` before `ends[c]`, behind those of the cell before.
    pub ends: Vec<usize>,
    pub nodes: Vec<i64>,
    /// Place of the nodes in the file.
    pub at: Place,
}

/// The lists of a surface in the order in which fields count their cells: VTK's type of these, keyword in legacy files, element in
/// XML and attribute of its length. All cells of a grid are in the place of the first.
pub(crate) const LISTS: [(u8, &[u8], &[u8], &str); 4] = [
    (2, b"VERTICES", b"Verts", "NumberOfVerts"),
    (4, b"LINES", b"Lines", "NumberOfLines"),
    (7, b"POLYGONS", b"Polys", "NumberOfPolys"),
    (6, b"TRIANGLE_STRIPS", b"Strips", "NumberOfStrips"),
];

/// The cells of a file before they are a grid, of triangles if they are a surface.
#[derive(Default)]
pub(crate) struct PolyData {
    pub is_surface: bool,
    pub lists: [Option<CellList>; 4],
}

impl PolyData {
    /// Number of cells in all lists.
    pub(super) fn cell_count(&self) -> usize {
        self.lists.iter().flatten().map(|list| list.ends.len()).sum()
    }

    /// Adds the cells to a grid. Of a surface, polygons become fans of triangles around their first corner, strips their
    /// triangles; each triangle takes its row of the fields.
    ///
    /// # Errors
    /// Polygons or strips of very many triangles with fields.
    pub(super) fn fill(self, grid: &mut MixedMesh) -> Result<()> {
        let cells = self.cell_count();
        if !self.is_surface {
            if let [Some(CellList { ends, nodes, at }), ..] = self.lists {
                (grid.ends, grid.connectivity, grid.cells_at) = (ends, nodes, at);
            }
            return Ok(());
        }
        // The row of the fields for each cell of the grid.
        let mut rows = Vec::new();
        let mut row = 0;
        for ((kind, ..), list) in LISTS.into_iter().zip(self.lists) {
            let Some(list) = list else { continue };
            // Errors point to triangles rather than to vertices and lines.
            if matches!(kind, 6 | 7) || grid.types.is_empty() {
                grid.cells_at = list.at;
            }
            let mut start = 0;
            for end in list.ends {
                add(grid, kind, &list.nodes[start..end]);
                start = end;
                rows.resize(grid.types.len(), row);
                row += 1;
            }
        }
        if !grid.cell_fields.is_empty() && rows.len() > MOST_REPEATED * cells.max(1) {
            let what = "cell fields on polygons or strips of";
            let value = format!("{} triangles each", rows.len() / cells.max(1));
            let advice = "split them into triangles first, for example with VTK's \"Triangulate\"";
            return Err(Refusal::unsupported(what, value, advice));
        }
        // A field of another size is refused with the grid.
        for field in grid.cell_fields.values_mut().filter(|field| field.rows() == cells) {
            *field = field.select(&rows);
        }
        Ok(())
    }
}

/// Adds one cell, a polygon or strip as triangles.
fn add(grid: &mut MixedMesh, kind: u8, nodes: &[i64]) {
    match (kind, nodes) {
        (2, [_]) => grid.push(1, nodes),
        (4, [_, _]) => grid.push(3, nodes),
        (7, [first, rest @ ..]) if rest.len() >= 2 => {
            rest.windows(2).for_each(|pair| grid.push(5, &[*first, pair[0], pair[1]]));
        }
        (6, [_, _, _, ..]) => {
            for (index, corners) in nodes.windows(3).enumerate() {
                let [a, b, c] = [corners[0], corners[1], corners[2]];
                grid.push(5, &if index % 2 == 0 { [a, b, c] } else { [b, a, c] });
            }
        }
        // A polygon or strip without a triangle in it is refused with its index.
        _ => grid.push(kind, nodes),
    }
}
