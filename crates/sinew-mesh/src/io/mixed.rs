//! Meshes that other programs hold in memory: cells of several kinds with fields and groups.

use super::grid::UnstructuredGrid;
use crate::{Field, MeshError, Problem};
use sinew_num::ascending;
use std::ops::Range;

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
#[derive(Debug)]
pub struct MixedMesh(pub(super) UnstructuredGrid);

impl MixedMesh {
    /// Nodes at their positions \[length\], without cells.
    pub fn new(points: Vec<[f64; 3]>) -> Self {
        Self(UnstructuredGrid { points, ..UnstructuredGrid::default() })
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
            let problem = Problem::Count { what, expected: nodes, found };
            return Err(MeshError::Cells(Box::new(problem)));
        }
        let grid = &mut self.0;
        let first = grid.types.len();
        indices.chunks_exact(nodes).for_each(|cell| grid.push(vtk_type, cell));
        Ok(first..grid.types.len())
    }

    /// Makes one node of those at the same place, as [`crate::read_merged`] does.
    pub fn merge_nodes(&mut self) {
        self.0.merge = true;
    }

    /// Number of cells of all kinds.
    pub fn cell_count(&self) -> usize {
        self.0.types.len()
    }

    /// Adds a field with a row per node.
    pub fn add_point_field(&mut self, name: impl Into<String>, field: Field) {
        self.0.point_fields.insert(name.into(), field);
    }

    /// Adds a field with a row per cell of any kind.
    pub fn add_cell_field(&mut self, name: impl Into<String>, field: Field) {
        self.0.cell_fields.insert(name.into(), field);
    }

    /// Names cells by their numbers among all cells: a cell set, a facet set of cells of the boundary, or the nodes of cells of still
    /// lower dimension.
    pub fn name_cells(&mut self, name: impl Into<String>, cells: impl IntoIterator<Item = usize>) {
        self.0.groups.entry(name.into()).or_default().extend(cells);
    }

    /// Names nodes.
    pub fn name_nodes(&mut self, name: impl Into<String>, nodes: impl IntoIterator<Item = usize>) {
        let set = self.0.node_sets.entry(name.into()).or_default();
        *set = ascending(set.drain(..).chain(nodes));
    }
}
