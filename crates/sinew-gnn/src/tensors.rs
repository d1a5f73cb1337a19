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
        emulator.local_embedding(&self.graph, self.nodes.clone(), self.edges.clone())
    }

    /// Displacements at standardised parameters \[length\], from the embeddings of its nodes.
    pub(crate) fn displacement(
        &self,
        emulator: &GraphNetwork,
        local: Embedding,
        mut parameters: Tensor<2>,
    ) -> Tensor<3> {
        if self.nodes.is_autodiff() {
            parameters = Tensor::from_inner(parameters);
        }
        let output = emulator.decode(local, self.global.clone(), parameters.clone());
        self.output.displacement(output, &parameters)
    }

    /// Tensors on the device of an automatically differentiated network.
    pub(crate) fn lifted(&self) -> Self {
        Self {
            graph: self.graph.clone(),
            nodes: Tensor::from_inner(self.nodes.clone()),
            edges: Tensor::from_inner(self.edges.clone()),
            global: self.global.clone().map(Tensor::from_inner),
            output: self.output.clone(),
        }
    }
}
