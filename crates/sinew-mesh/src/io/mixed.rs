//! Meshes that other programs hold in memory.

use super::grid::MixedMesh;
use crate::{MeshError, Problem};
use sinew_num::ascending;
use std::ops::Range;

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
            let problem = Problem::Count { what, expected: nodes, found };
            return Err(MeshError::Cells(Box::new(problem)));
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
}
