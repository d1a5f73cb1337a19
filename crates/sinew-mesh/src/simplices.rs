//! Tetrahedra in hexahedra.

use crate::{Facet, HexMesh, TetMesh};

/// A tetrahedron at each corner of a hexahedron, of the corner and its three neighbours, and the two between four of these.
const TETRAHEDRA: [[usize; 4]; 10] = [
    [0, 1, 3, 4],
    [1, 2, 0, 5],
    [2, 3, 1, 6],
    [3, 0, 2, 7],
    [4, 7, 5, 0],
    [5, 4, 6, 1],
    [6, 5, 7, 2],
    [7, 6, 4, 3],
    [0, 2, 7, 5],
    [1, 3, 4, 6],
];

impl HexMesh {
    /// Ten tetrahedra of each hexahedron, by both of its divisions into five: they cover it twice. Quadratic
    /// functionals, such as that of Laplace's equation, are twice as large on them, and exact for linear functions, whichever
    /// diagonals neighbours have. Nodes and facet sets are kept, fields and other sets are not.
    ///
    /// ```
    /// let block = sinew_mesh::box_hexahedra([2.0, 1.0, 1.0], [2, 1, 1]);
    /// let cells = block.overlapping_tetrahedra();
    /// let volume: f64 = (0..cells.cells.len()).map(|cell| cells.cell_volume(cell)).sum();
    /// assert_eq!(cells.cells.len(), 20);
    /// assert!((volume - 2.0 * 2.0).abs() < 1e-12);
    /// let [of_block, of_cells] = [
    ///     block.nodes_of_facets(&block.facet_sets["x_max"]),
    ///     cells.nodes_of_facets(&cells.facet_sets["x_max"]),
    /// ];
    /// assert_eq!(of_block, of_cells);
    /// ```
    pub fn overlapping_tetrahedra(&self) -> TetMesh {
        let cells = self.cells.iter().flat_map(|cell| TETRAHEDRA.map(|own| own.map(|n| cell[n])));
        let halves = |facet: &Facet| {
            let corners = Self::ELEMENT.facets[facet.opposite];
            let cell = TETRAHEDRA.len() * facet.cell;
            let off = |corner: usize| TETRAHEDRA[corner].iter().position(|n| !corners.contains(n));
            [0, 2].map(|k| (corners[k], off(corners[k]))).into_iter().filter_map(
                move |(corner, off)| Some(Facet { cell: cell + corner, opposite: off? }),
            )
        };
        let sets = self.facet_sets.iter();
        let facet_sets =
            sets.map(|(name, facets)| (name.clone(), facets.iter().flat_map(halves).collect()));
        TetMesh {
            points: self.points.clone(),
            cells: cells.collect(),
            facet_sets: facet_sets.collect(),
            ..TetMesh::default()
        }
    }
}
