//! A geometry as tensors.

use crate::map::OutputMap;
use crate::{Embedding, Graph, GraphNetwork};
use burn::tensor::Tensor;
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
