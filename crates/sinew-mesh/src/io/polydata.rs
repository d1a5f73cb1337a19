//! VTK's surfaces: vertices, lines, polygons and strips, in legacy files (POLYDATA) and in XML (VTP).

use super::cursor::Result;
use super::grid::MixedMesh;
use crate::{Place, Problem};

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

/// The lists of cells in the order in which fields count them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub(crate) enum Kind {
    /// Vertices of a surface, or all cells of a grid.
    Vertices,
    Lines,
    Polygons,
    Strips,
}

/// The cells of a file before they are a grid, of triangles if they are a surface.
#[derive(Default)]
pub(crate) struct PolyData {
    pub is_surface: bool,
    pub lists: [Option<CellList>; 4],
}

impl Kind {
    /// Kind by the keyword of legacy files, of a surface or a grid.
    pub(super) fn of_keyword(keyword: &[u8], of_surface: bool) -> Option<Self> {
        Some(match (keyword, of_surface) {
            (b"CELLS", false) | (b"VERTICES", true) => Kind::Vertices,
            (b"LINES", true) => Kind::Lines,
            (b"POLYGONS", true) => Kind::Polygons,
            (b"TRIANGLE_STRIPS", true) => Kind::Strips,
            _ => return None,
        })
    }
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
        let kinds = [Kind::Vertices, Kind::Lines, Kind::Polygons, Kind::Strips];
        // The row of the fields for each cell of the grid.
        let mut rows = Vec::new();
        let mut row = 0;
        for (kind, list) in kinds.into_iter().zip(self.lists) {
            let Some(list) = list else { continue };
            if kind >= Kind::Polygons || grid.types.is_empty() {
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
            return Err(Problem::unsupported(what, value, advice));
        }
        // A field of another size is refused with the grid.
        for field in grid.cell_fields.values_mut().filter(|field| field.rows() == cells) {
            *field = field.select(&rows);
        }
        Ok(())
    }
}

/// Adds one cell, a polygon or strip as triangles.
fn add(grid: &mut MixedMesh, kind: Kind, nodes: &[i64]) {
    match (kind, nodes) {
        (Kind::Vertices, [_]) => grid.push(1, nodes),
        (Kind::Vertices, _) => grid.push(2, nodes),
        (Kind::Lines, [_, _]) => grid.push(3, nodes),
        (Kind::Lines, _) => grid.push(4, nodes),
        (Kind::Polygons, [first, rest @ ..]) if rest.len() >= 2 => {
            rest.windows(2).for_each(|pair| grid.push(5, &[*first, pair[0], pair[1]]));
        }
        (Kind::Strips, [_, _, _, ..]) => {
            for (index, corners) in nodes.windows(3).enumerate() {
                let [a, b, c] = [corners[0], corners[1], corners[2]];
                grid.push(5, &if index % 2 == 0 { [a, b, c] } else { [b, a, c] });
            }
        }
        // A polygon or strip without a triangle in it is refused with its index.
        _ => grid.push(if kind == Kind::Strips { 6 } else { 7 }, nodes),
    }
}
