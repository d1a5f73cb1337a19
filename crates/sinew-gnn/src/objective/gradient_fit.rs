//! Deformation gradients of displacements.

use burn::tensor::{Int, Tensor, TensorData};

use crate::{Geometry, Result};
use sinew_emulate::coordinates::{CoordinateError, require_count, require_finite};

/// Gradients of the shape functions of one geometry's linear simplices, constant per cell.
#[derive(Debug, Clone, PartialEq)]
pub struct GradientOperator {
    /// Nodes per cell, `D + 1` for simplices.
    pub nodes_per_cell: usize,
    /// Nodes of all cells, cell by cell.
    pub cells: Vec<usize>,
    /// `∂N_a/∂X_j`: cell by cell, node by node, component by component [1/length].
    pub shape_gradients: Vec<f64>,
}

impl GradientOperator {
    pub(super) fn check(&self, geometry: &Geometry) -> Result<()> {
        require_finite("shape gradients", &self.shape_gradients)?;
        if self.nodes_per_cell == 0 || self.cells.is_empty() {
            require_count("cells of a gradient operator", 0, 1)?;
        }
        let loose = self.cells.len() % self.nodes_per_cell;
        require_count("cell nodes beyond whole cells", loose, 0)?;
        let nodes = geometry.topology.real_nodes;
        let dimensions = geometry.dirichlet.prescribed.len() / nodes.max(1);
        let expected = self.cells.len() * dimensions;
        require_count("shape gradients", self.shape_gradients.len(), expected)?;
        match self.cells.iter().find(|&&node| node >= nodes) {
            None => Ok(()),
            Some(&found) => {
                let what = "node index of a cell";
                Err(CoordinateError::Count { what, found, expected: nodes }.into())
            }
        }
    }

    /// Squared norms of the displacement gradients, `[batch, cells, 1]`.
    pub(super) fn squared_gradient(&self, displacement: Tensor<3>) -> Tensor<3> {
        let [batch, _, dimensions] = displacement.dims();
        let cells = self.cells.len() / self.nodes_per_cell;
        let device = displacement.device();
        let shape = [batch, cells, self.nodes_per_cell, dimensions];
        let nodes: Vec<i32> = self.cells.iter().map(|&node| node as i32).collect();
        let nodes = Tensor::<1, Int>::from_data(&nodes[..], &device);
        let of_cells = displacement.select(1, nodes).reshape(shape);
        let column = |component| {
            // `∂N_a/∂X_j` for one j.
            let values = self.shape_gradients.iter().skip(component).step_by(dimensions);
            let values: Vec<f32> = values.map(|&value| value as f32).collect();
            let values = TensorData::new(values, [1, cells, self.nodes_per_cell, 1]);
            let gradient = Tensor::from_data(values, &device);
            let column = (of_cells.clone() * gradient).sum_dim(2);
            let column = column.reshape([batch, cells, dimensions]);
            (column.clone() * column).sum_dim(2)
        };
        let columns = (0..dimensions).map(column);
        columns.reduce(|sum, column| sum + column).expect("displacements have components")
    }
}
