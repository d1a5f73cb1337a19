//! Data-driven training on displacements and their gradients.

use burn::tensor::{Device, Int, Tensor, TensorData};

use super::{Batch, DataFit, Objective, SQUARED_NORM_FLOOR};
use crate::{DataSet, Result};
use sinew_emulate::coordinates::{
    CoordinateError, require_count, require_finite, require_positive,
};

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

/// Displacements and deformation gradients, `mean ‖u − û‖₂ + w mean ‖F − F̂‖_F` (thesis, Equation B.1).
///
/// Nodal distances are in units of a characteristic length; deformation gradients have none.
#[derive(Debug, Clone, PartialEq)]
pub struct DataFitWithGradient {
    /// Weight w of the second term.
    pub weight: f64,
    fit: DataFit,
    operators: Vec<GradientOperator>,
}

impl DataFitWithGradient {
    /// Objective with one operator per geometry.
    ///
    /// # Errors
    /// A length or weight that is not positive, gradients that are not finite or do not fit the cells.
    pub fn new(length: f64, weight: f64, operators: Vec<GradientOperator>) -> Result<Self> {
        require_positive("the weight of the deformation gradients", weight)?;
        for operator in &operators {
            require_finite("shape gradients", &operator.shape_gradients)?;
            if operator.nodes_per_cell == 0 || operator.cells.is_empty() {
                return Err(CoordinateError::Count {
                    what: "cells of a gradient operator",
                    found: 0,
                    expected: 1,
                }
                .into());
            }
            let loose = operator.cells.len() % operator.nodes_per_cell;
            require_count("cell nodes beyond whole cells", loose, 0)?;
        }
        Ok(Self { weight, fit: DataFit::new(length)?, operators })
    }
}

impl Objective for DataFitWithGradient {
    fn check(&self, data: &DataSet) -> Result<()> {
        self.fit.check(data)?;
        require_count("gradient operators", self.operators.len(), data.geometries.len())?;
        for (operator, geometry) in self.operators.iter().zip(&data.geometries) {
            let nodes = geometry.topology.real_nodes;
            let dimensions = geometry.dirichlet.prescribed.len() / nodes.max(1);
            let expected = operator.cells.len() * dimensions;
            require_count("shape gradients", operator.shape_gradients.len(), expected)?;
            if let Some(&node) = operator.cells.iter().find(|&&node| node >= nodes) {
                return Err(CoordinateError::Count {
                    what: "node index of a cell",
                    found: node,
                    expected: nodes,
                }
                .into());
            }
        }
        Ok(())
    }

    fn loss(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> Result<Tensor<1>> {
        let simulated = TensorData::new(DataFit::simulated(batch), displacement.dims());
        let simulated = Tensor::from_data(simulated, &displacement.device());
        let difference = (displacement.clone() - simulated) / self.fit.length;
        let squared = self.operators[batch.geometry].squared_gradient(difference);
        // F − F̂ = ∇(u − û): the length that made u dimensionless is put back.
        let weight = self.weight * self.fit.length;
        Ok(self.fit.loss(batch, displacement)?
            + (squared + SQUARED_NORM_FLOOR).sqrt().mean() * weight)
    }
}

impl GradientOperator {
    /// Squared norms of the displacement gradients, `[batch, cells, 1]`.
    fn squared_gradient(&self, displacement: Tensor<3>) -> Tensor<3> {
        let [batch, _, dimensions] = displacement.dims();
        let cells = self.cells.len() / self.nodes_per_cell;
        let device = displacement.device();
        let shape = [batch, cells, self.nodes_per_cell, dimensions];
        let nodes: Vec<i32> = self.cells.iter().map(|&node| node as i32).collect();
        let nodes = Tensor::<1, Int>::from_data(&nodes[..], &device);
        let of_cells = displacement.select(1, nodes).reshape(shape);
        let column = |component| {
            let gradient = self.column(component, dimensions, &device);
            let column = (of_cells.clone() * gradient).sum_dim(2);
            let column = column.reshape([batch, cells, dimensions]);
            (column.clone() * column).sum_dim(2)
        };
        let columns = (0..dimensions).map(column);
        columns.reduce(|sum, column| sum + column).expect("displacements have components")
    }

    /// `∂N_a/∂X_j` for one j: `[1, cells, nodes per cell, 1]`.
    fn column(&self, component: usize, dimensions: usize, device: &Device) -> Tensor<4> {
        let values = self.shape_gradients.iter().skip(component).step_by(dimensions);
        let values: Vec<f32> = values.map(|&value| value as f32).collect();
        let cells = self.cells.len() / self.nodes_per_cell;
        Tensor::from_data(TensorData::new(values, [1, cells, self.nodes_per_cell, 1]), device)
    }
}
