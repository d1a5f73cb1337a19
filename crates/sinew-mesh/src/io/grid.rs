//! Content common to all mesh formats: cells of any type with fields and groups.

use super::cursor::Result;
use crate::geometry::{extents, merged};
use crate::{Field, MeshError, Place, Refusal, SELECTION_TOLERANCE};
use nalgebra::Vector3;
use sinew_num::ascending;
use std::collections::BTreeMap;
use std::ops::Range;

/// Distance of nodes that may be meant to be one [relative to the shortest edge there]: far less than a cell, far more than digits of a file.
const NEAR: f64 = 0.01;

/// Cells of several kinds in memory, as mesh files hold them, with fields and named groups.
///
/// [`MixedMesh::into_mesh`] makes a mesh of the cells of the highest dimension; those of the boundary become facet sets.
///
/// ```
/// use sinew_mesh::MixedMesh;
///
/// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let mut mixed = MixedMesh::new(corners);
/// mixed.add_cells(10, 4, &[0, 1, 2, 3])?; // a tetrahedron, by VTK's number
/// let triangle = mixed.add_cells(5, 3, &[0, 1, 2])?;
/// mixed.name_cells("bottom", triangle);
/// let (mesh, report) = mixed.into_mesh()?;
/// assert_eq!((mesh.cell_count(), mesh.facet_sets()["bottom"].len(), report.matched_facets), (1, 1, 1));
/// # Ok::<(), sinew_mesh::MeshError>(())
/// ```
#[derive(Debug, Default)]
pub struct MixedMesh {
    pub(crate) points: Vec<[f64; 3]>,
    /// VTK cell type of each cell.
    pub(crate) types: Vec<u8>,
    /// The nodes of cell `c` stand in `connectivity` before `ends[c]`, behind those of the cell before.
    pub(crate) ends: Vec<usize>,
    pub(crate) connectivity: Vec<i64>,
    /// Named fields with one row per node.
    pub point_fields: BTreeMap<String, Field>,
    /// Named fields with one row per cell of any kind.
    pub cell_fields: BTreeMap<String, Field>,
    /// Named groups of cells of any type.
    pub(crate) groups: BTreeMap<String, Vec<usize>>,
    /// Named sets of points.
    pub(crate) node_sets: BTreeMap<String, Vec<usize>>,
    /// Named sets of facets: cells, each with our number of its facet.
    pub(crate) sides: BTreeMap<String, Vec<(usize, usize)>>,
    /// Arrays and elements that the reader left out, a phrase each.
    pub(crate) left_out: Vec<String>,
    /// Whether the reader took the file's lengths for µm, and made mm of them.
    pub(crate) in_micrometres: bool,
    /// Whether nodes at the same place become one, as [`crate::read_merged`] makes them.
    pub merge: bool,
    /// Place of the points, for errors.
    pub(crate) points_at: Place,
    /// Place of the cells, for errors.
    pub(crate) cells_at: Place,
}

impl MixedMesh {
    /// Nodes at their positions \[length\], without cells.
    pub fn new(points: Vec<[f64; 3]>) -> Self {
        Self { points, ..Self::default() }
    }

    /// Adds cells of one kind, by VTK's number for it, with so many `nodes` each in VTK's order; their numbers among all cells.
    ///
    /// # Errors
    /// Indices that do not divide into cells. Indices of nodes that there are not are an error of [`MixedMesh::into_mesh`].
    pub fn add_cells(
        &mut self,
        vtk_type: u8,
        nodes: usize,
        indices: &[i64],
    ) -> Result<Range<usize>, MeshError> {
        if nodes == 0 || !indices.len().is_multiple_of(nodes) {
            let what = format!("indices of a cell of {nodes} nodes");
            let found = indices.len() % nodes.max(1);
            Refusal::require_count(what, nodes, found)?;
        }
        let first = self.types.len();
        indices.chunks_exact(nodes).for_each(|cell| self.push(vtk_type, cell));
        Ok(first..self.types.len())
    }

    /// Names cells by their numbers among all cells: a cell set, a facet set of cells of the boundary, or the nodes of cells of still
    /// lower dimension.
    pub fn name_cells(&mut self, name: impl Into<String>, cells: impl IntoIterator<Item = usize>) {
        self.groups.entry(name.into()).or_default().extend(cells);
    }

    /// Names nodes.
    pub fn name_nodes(&mut self, name: impl Into<String>, nodes: impl IntoIterator<Item = usize>) {
        let set = self.node_sets.entry(name.into()).or_default();
        *set = ascending(set.drain(..).chain(nodes));
    }

    pub(super) fn cell(&self, index: usize) -> &[i64] {
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.connectivity[start..self.ends[index]]
    }

    /// Nodes of a cell; one that is negative becomes very large.
    pub(super) fn nodes(&self, index: usize) -> impl Iterator<Item = usize> {
        self.cell(index).iter().map(|&node| node as usize)
    }

    /// Adds a field of the points, or of the cells.
    pub(super) fn add_field(&mut self, of_points: bool, name: String, field: Field) -> Result<()> {
        if name.is_empty() || name.contains(char::is_control) {
            self.left_out.push(format!("array of the name `{}`", name.escape_debug()));
            return Ok(());
        }
        let fields = if of_points { &mut self.point_fields } else { &mut self.cell_fields };
        // VTK writes one that is active as scalars and as vectors twice.
        if fields.get(&name).is_some_and(|known| *known != field) {
            let advice = "write a single time step, and give each array a name of its own";
            return Err(Refusal::unsupported("a second array of the name", name, advice));
        }
        fields.insert(name, field);
        Ok(())
    }

    /// Whether each cell is a ghost of another piece, or hidden, by the bits of VTK's array `vtkGhostType`.
    pub(super) fn ghosts(&self) -> Vec<bool> {
        /// A duplicate, one that others replace, and a hidden one (vtkDataSetAttributes).
        const NOT_SHOWN: i64 = 1 | 8 | 32;
        let bits = self.cell_fields.get("vtkGhostType").and_then(Field::to_labels);
        let ghosts = bits.map(|bits| bits.iter().map(|bits| bits & NOT_SHOWN != 0).collect());
        ghosts.unwrap_or_else(|| vec![false; self.types.len()])
    }

    /// Number of nodes of cells at the place of another, of those that become one with it where nodes are merged, and of those so near to
    /// another that they may be meant to.
    pub(super) fn coincident(&mut self, ghosts: &[bool]) -> [usize; 3] {
        let limit = self.points.len();
        let shown = || (0..self.types.len()).filter(|&cell| !ghosts[cell]);
        let used = ascending(shown().flat_map(|cell| self.nodes(cell)).filter(|&n| n < limit));
        let places: Vec<_> = used.iter().map(|&node| self.points[node]).collect();
        let tolerance = SELECTION_TOLERANCE * Vector3::from(extents(&places)).norm();
        let within = |reach: &dyn Fn(usize) -> f64| {
            let mut first: Vec<usize> = (0..limit).collect();
            let merged = merged(&places, |at| reach(used[at]));
            used.iter().zip(merged).for_each(|(&node, at)| first[node] = used[at]);
            first
        };
        let first = within(&|_| tolerance);
        let count = first.iter().enumerate().filter(|(node, first)| node != *first).count();
        let edges = self.shortest_edges(shown());
        let near = within(&|node| NEAR * edges[node]);
        let is_near = |(node, near): &(usize, &usize)| first[*node] != first[**near];
        let near = near.iter().enumerate().filter(is_near).count();
        if !self.merge {
            return [count, 0, near];
        }
        let joined = |node: usize| first.get(node).copied().unwrap_or(node);
        self.connectivity.iter_mut().for_each(|node| *node = joined(*node as usize) as i64);
        for set in self.node_sets.values_mut() {
            *set = ascending(set.iter().map(|&node| joined(node)));
        }
        self.point_fields.values_mut().for_each(|field| *field = field.joined(&first));
        [0, count, near]
    }

    /// Distance of each point from the nearest other node of some cells; 0 of those of none, or of lines through any number.
    fn shortest_edges(&self, cells: impl Iterator<Item = usize>) -> Vec<f64> {
        let mut shortest = vec![f64::INFINITY; self.points.len()];
        for index in cells.filter(|&index| cell_type(self.types[index]).2.is_some()) {
            let nodes: Vec<_> = self.nodes(index).filter(|&n| n < self.points.len()).collect();
            for (at, &a) in nodes.iter().enumerate() {
                for &b in nodes[..at].iter().filter(|&&b| b != a) {
                    let way = Vector3::from(self.points[a]) - Vector3::from(self.points[b]);
                    [a, b].into_iter().for_each(|n| shortest[n] = shortest[n].min(way.norm()));
                }
            }
        }
        shortest.into_iter().map(|edge| if edge.is_finite() { edge } else { 0.0 }).collect()
    }

    /// Gives Lagrange cells of first and second order, voxels and pixels the types whose nodes these have.
    pub(super) fn rename_equal_cells(&mut self) {
        let mut start = 0;
        for (kind, end) in self.types.iter_mut().zip(&self.ends) {
            let nodes = &mut self.connectivity[start..*end];
            start = *end;
            *kind = match (*kind, nodes.len()) {
                (68, 2) => 3,
                (68, 3) => 21,
                (69, 3) => 5,
                (69, 6) => 22,
                (70, 4) => 9,
                (70, 9) => 28,
                (71, 4) => 10,
                (71, 10) => 24,
                (72, 8) => 12,
                (8, 4) | (11, 8) => {
                    // Their nodes run along the first axis, then the second.
                    nodes.chunks_exact_mut(4).for_each(|layer| layer.swap(2, 3));
                    *kind + 1
                }
                (other, _) => other,
            };
        }
    }

    /// Gives the cells their types by VTK's numbers. Unknown ones are refused with their cell's index later.
    pub(super) fn set_types(&mut self, types: &[i64]) {
        self.types = types.iter().map(|&kind| u8::try_from(kind).unwrap_or(u8::MAX)).collect();
    }

    /// Adds a cell.
    pub(super) fn push(&mut self, vtk_type: u8, nodes: &[i64]) {
        self.types.push(vtk_type);
        self.connectivity.extend_from_slice(nodes);
        self.ends.push(self.connectivity.len());
    }
}

/// Indices of nodes by their numbers in the file.
pub(super) fn indices<'i>(
    numbers: &[i64],
    expected: &'static str,
    index: impl Fn(&i64) -> Option<&'i usize>,
) -> Result<Vec<i64>> {
    let unknown = |number: &i64| Refusal::expected(expected, number.to_string());
    let of = |number| index(number).map(|&index| index as i64).ok_or_else(|| unknown(number));
    numbers.iter().map(of).collect()
}

/// VTK's numbers of cell types (VTK User's Guide, "VTK File Formats"): name, dimension, and nodes where their number is fixed.
pub(super) const CELL_TYPES: [(u8, &str, i64, Option<usize>); 29] = [
    (1, "vertex", 0, Some(1)),
    (2, "poly-vertex", 0, None),
    (3, "line", 1, Some(2)),
    (4, "poly-line", 1, None),
    (5, "triangle", 2, Some(3)),
    (6, "triangle strip", 2, None),
    (7, "polygon", 2, None),
    (8, "pixel", 2, Some(4)),
    (9, "quadrilateral", 2, Some(4)),
    (10, "tetrahedron", 3, Some(4)),
    (11, "voxel", 3, Some(8)),
    (12, "hexahedron", 3, Some(8)),
    (13, "wedge", 3, Some(6)),
    (14, "pyramid", 3, Some(5)),
    (21, "quadratic edge", 1, Some(3)),
    (22, "quadratic triangle", 2, Some(6)),
    (23, "quadratic quadrilateral", 2, Some(8)),
    (24, "quadratic tetrahedron", 3, Some(10)),
    (25, "quadratic hexahedron", 3, Some(20)),
    (26, "quadratic wedge", 3, Some(15)),
    (27, "quadratic pyramid", 3, Some(13)),
    (28, "biquadratic quadrilateral", 2, Some(9)),
    (29, "triquadratic hexahedron", 3, Some(27)),
    (42, "polyhedron", 3, None),
    (68, "Lagrange curve", 1, None),
    (69, "Lagrange triangle", 2, None),
    (70, "Lagrange quadrilateral", 2, None),
    (71, "Lagrange tetrahedron", 3, None),
    (72, "Lagrange hexahedron", 3, None),
];

/// Name of a VTK cell type, its dimension, and its number of nodes where that is fixed.
pub(crate) fn cell_type(vtk_type: u8) -> (&'static str, i64, Option<usize>) {
    let known = CELL_TYPES.iter().find(|(number, ..)| *number == vtk_type);
    let &(_, name, dimension, nodes) = known.unwrap_or(&(0, "cell of another type", 3, None));
    (name, dimension, nodes)
}
