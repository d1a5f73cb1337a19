//! A topology's edges as tensors.

use std::ops::Range;
use std::sync::Arc;

use burn::tensor::{Device, IndexingUpdateOp, Int, Tensor, TensorData};
use sinew_burn::{EdgeTopology, GatherPlan};
use sinew_graph::Topology;

use crate::error::Result;

/// Senders and receivers of the stored half of the edges, for both kinds of kernels.
#[derive(Debug, Clone)]
pub struct GraphTensors {
    /// Nodes of each layer, the real ones first.
    pub(crate) layers: Vec<Range<usize>>,
    pub(crate) edges: Arc<EdgeTopology>,
    pub(crate) plan: Arc<GatherPlan>,
    senders: Tensor<1, Int>,
    receivers: Tensor<1, Int>,
}

impl GraphTensors {
    /// Puts a topology's edges on a device.
    ///
    /// # Errors
    /// Edges between nodes that do not exist, or more than 32-bit indices can number.
    pub fn new(topology: &Topology, device: &Device) -> Result<Self> {
        let edges = EdgeTopology::new(topology.nodes, &topology.senders, &topology.receivers)?;
        let device = device.clone().without_autodiff();
        let upload = |indices: &[u32]| {
            let indices: Vec<i64> = indices.iter().map(|&index| i64::from(index)).collect();
            let count = indices.len();
            Tensor::<1, Int>::from_data(TensorData::new(indices, [count]), &device)
        };
        Ok(Self {
            layers: (0..=topology.clusters.len()).map(|layer| topology.layer(layer)).collect(),
            senders: upload(edges.senders()),
            receivers: upload(edges.receivers()),
            plan: GatherPlan::edges(&edges),
            edges,
        })
    }

    /// Rows of `nodes` at the senders, one per edge.
    pub(crate) fn at_senders(&self, nodes: Tensor<2>) -> Tensor<2> {
        nodes.select(0, self.senders.clone())
    }

    /// Rows of `nodes` at the receivers, one per edge.
    pub(crate) fn at_receivers(&self, nodes: Tensor<2>) -> Tensor<2> {
        nodes.select(0, self.receivers.clone())
    }

    /// Received minus sent messages at every node, in plain tensors.
    pub(crate) fn signed_sum(&self, messages: Tensor<2>) -> Tensor<2> {
        let received = self.received_sum(messages.clone());
        received.select_assign(0, self.senders.clone(), messages.neg(), IndexingUpdateOp::Add)
    }

    /// Received messages at every node, in plain tensors.
    pub(crate) fn received_sum(&self, messages: Tensor<2>) -> Tensor<2> {
        let zeros = Tensor::zeros([self.edges.nodes(), messages.dims()[1]], &messages.device());
        zeros.select_assign(0, self.receivers.clone(), messages, IndexingUpdateOp::Add)
    }
}
