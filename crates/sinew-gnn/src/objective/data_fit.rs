//! Data-driven training, on displacements and deformation gradients.

use super::{Objective, SQUARED_NORM_FLOOR};
use crate::fused::mean_distance;
use crate::{DataSet, Geometry, Result, Sample};
use burn::tensor::{Int, Tensor, TensorData};
use sinew_emulate::coordinates::{
    CoordinateError, require_count, require_finite, require_positive,
};

/// Mean nodal distance between simulated and predicted displacement, `mean ‖u − û‖₂`
/// (thesis, Equation 3.11), in units of a characteristic length; with deformation gradients, which have no unit, `… + w mean ‖F − F̂‖_F`
/// (Equation B.1).
#[doc(alias = "supervised")]
#[derive(Debug, Clone, PartialEq)]
pub struct DataFit {
    /// The characteristic length \[length\].
    length: f64,
    /// Weight of the deformation gradients, with one operator per geometry.
    gradients: Option<(f64, Vec<GradientOperator>)>,
}

impl DataFit {
    /// `length` makes distances dimensionless, usually
    /// [`OutputScale::length`](sinew_emulate::coordinates::OutputScale::length) \[length\].
    ///
    /// # Errors
    /// A length that is not positive.
    pub fn new(length: f64) -> Result<Self> {
        require_positive("the characteristic length of the displacements", length)?;
        Ok(Self { length, gradients: None })
    }

    /// The objective with deformation gradients, by one operator per geometry.
    ///
    /// # Errors
    /// A weight that is not positive.
    pub fn with_gradients(self, weight: f64, operators: Vec<GradientOperator>) -> Result<Self> {
        require_positive("the weight of the deformation gradients", weight)?;
        Ok(Self { gradients: Some((weight, operators)), ..self })
    }
}

impl Objective for DataFit {
    fn check(&self, data: &DataSet) -> Result<()> {
        data.training.iter().chain(&data.validation).try_for_each(|sample| {
            let geometry = data.geometries.get(sample.geometry);
            let expected = geometry.map_or(0, |body| body.dirichlet.prescribed.len());
            let what =
                "displacement values of a sample (data-driven training needs a simulation of each)";
            require_count(what, sample.displacement.len(), expected)
        })?;
        let Some((_, operators)) = &self.gradients else { return Ok(()) };
        require_count("gradient operators", operators.len(), data.geometries.len())?;
        let mut all = operators.iter().zip(&data.geometries);
        all.try_for_each(|(operator, geometry)| operator.check(geometry))
    }

    fn loss(&self, samples: &[&Sample], displacement: Tensor<3>) -> Result<Tensor<1>> {
        let (unit, floor) = (self.length as f32, SQUARED_NORM_FLOOR as f32);
        let simulated = samples.iter().flat_map(|sample| &sample.displacement);
        let simulated: Vec<f32> = simulated.map(|&value| value as f32).collect();
        let Some((weight, operators)) = &self.gradients else {
            return Ok(mean_distance(displacement, simulated, unit, floor));
        };
        let field = TensorData::new(simulated.clone(), displacement.dims());
        let field = Tensor::from_data(field, &displacement.device());
        let difference = (displacement.clone() - field) / self.length;
        let squared = operators[samples[0].geometry].squared_gradient(difference);
        // F − F̂ = ∇(u − û): the length that made u dimensionless is put back.
        Ok(mean_distance(displacement, simulated, unit, floor)
            + (squared + SQUARED_NORM_FLOOR).sqrt().mean() * (weight * self.length))
    }
}

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
