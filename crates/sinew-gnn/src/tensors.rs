//! Numbers as tensors, and a geometry as tensors.

use crate::error::Result;
use crate::map::OutputMap;
use crate::{Embedding, Graph, GraphNetwork};
use burn::tensor::{Device, Tensor, TensorData};
use sinew_emulate::coordinates::ParameterScaling;
use std::sync::Arc;

/// A geometry's tensors, without automatic differentiation.
#[derive(Debug, Clone)]
pub(crate) struct GeometryTensors {
    /// Edges and layers of the graph.
    pub graph: Graph,
    /// `[nodes, features]`, standardised.
    pub nodes: Tensor<2>,
    /// `[edges, features]`, standardised.
    pub edges: Tensor<2>,
    /// `[1, global features]`, standardised.
    pub global: Option<Tensor<2>>,
    /// Map from network outputs to nodal displacements \[length\].
    pub output: Arc<OutputMap>,
}

impl GeometryTensors {
    /// Embeddings of its nodes by message passing.
    pub(crate) fn embedding(&self, emulator: &GraphNetwork) -> Embedding {
        let [nodes, edges] = [&self.nodes, &self.edges].map(|table| emulator.lifted(table));
        emulator.local_embedding(&self.graph, nodes, edges)
    }

    /// Displacements at standardised parameters \[length\], from the embeddings of its nodes.
    pub(crate) fn displacement(
        &self,
        emulator: &GraphNetwork,
        local: Embedding,
        parameters: &Tensor<2>,
    ) -> Tensor<3> {
        let global = self.global.as_ref().map(|table| emulator.lifted(table));
        let outputs = emulator.decode(local, global, emulator.lifted(parameters));
        self.output.displacement(outputs, parameters)
    }
}

/// Standardised parameters `[batch, parameters]`.
pub(crate) fn parameter_tensor<'a>(
    scaling: &ParameterScaling,
    thetas: impl ExactSizeIterator<Item = &'a [f64]>,
    device: &Device,
) -> Result<Tensor<2>> {
    let rows = thetas.len();
    Ok(matrix(&standardised(scaling, thetas)?.concat(), rows, device))
}

/// Standardised parameter sets.
pub(crate) fn standardised<'a>(
    scaling: &ParameterScaling,
    thetas: impl Iterator<Item = &'a [f64]>,
) -> Result<Vec<Vec<f64>>> {
    thetas.map(|theta| Ok(scaling.standardise(theta)?)).collect()
}

/// `[rows, columns]` in single precision.
pub(crate) fn matrix(values: &[f64], rows: usize, device: &Device) -> Tensor<2> {
    let columns = values.len() / rows.max(1);
    let values: Vec<f32> = values.iter().map(|&value| value as f32).collect();
    Tensor::from_data(TensorData::new(values, [rows, columns]), device)
}

/// Numbers of a tensor on the host.
pub(crate) fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f64> {
    let data = tensor.into_data();
    match data.as_slice::<f32>() {
        Ok(values) => values.iter().map(|&value| f64::from(value)).collect(),
        Err(_) => data.iter::<f64>().collect(),
    }
}
