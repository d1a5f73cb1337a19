//! A topology's edges as tensors.

use std::sync::Arc;

use burn::tensor::{Device, IndexingUpdateOp, Int, Tensor, TensorData};
use sinew_graph::Topology;

use crate::error::{Error, Result};

/// Senders and receivers of the stored half of the edges on a device.
#[derive(Debug, Clone)]
pub struct GraphTensors {
    pub(crate) real_nodes: usize,
    pub(crate) nodes: usize,
    pub(crate) edges: usize,
    senders: Tensor<1, Int>,
    receivers: Tensor<1, Int>,
    pub(crate) incidence: Arc<Incidence>,
}

/// Node indices of the stored edges for host-side kernels.
#[derive(Debug)]
pub(crate) struct Incidence {
    pub senders: Vec<u32>,
    pub receivers: Vec<u32>,
}

impl GraphTensors {
    /// Puts a topology's edges on a device.
    ///
    /// # Errors
    /// [`Error::Count`] if the topology has no nodes or more than fit the index type.
    pub fn new(topology: &Topology, device: &Device) -> Result<Self> {
        let limit = i32::MAX as usize;
        if topology.nodes == 0 || topology.nodes > limit || topology.senders.len() > limit {
            return Err(Error::Count {
                what: "nodes of the topology",
                found: topology.nodes,
                expected: 1,
            });
        }
        let device = device.clone().without_autodiff();
        let upload = |indices: &[usize]| {
            let indices: Vec<i32> = indices.iter().map(|&index| index as i32).collect();
            let count = indices.len();
            Tensor::<1, Int>::from_data(TensorData::new(indices, [count]), &device)
        };
        let narrow = |indices: &[usize]| indices.iter().map(|&index| index as u32).collect();
        Ok(Self {
            real_nodes: topology.real_nodes,
            nodes: topology.nodes,
            edges: topology.senders.len(),
            senders: upload(&topology.senders),
            receivers: upload(&topology.receivers),
            incidence: Arc::new(Incidence {
                senders: narrow(&topology.senders),
                receivers: narrow(&topology.receivers),
            }),
        })
    }

    /// Rows of `x` at the senders and receivers, `[edges, features]` each.
    pub(crate) fn gather(
        &self,
        at_senders: Tensor<2>,
        at_receivers: Tensor<2>,
    ) -> (Tensor<2>, Tensor<2>) {
        (at_senders.select(0, self.senders.clone()), at_receivers.select(0, self.receivers.clone()))
    }

    /// Sum of received minus sent messages at every node: the stored half and its negative twin (2.27).
    pub(crate) fn signed_sum(&self, messages: Tensor<2>) -> Tensor<2> {
        let received = self.received_sum(messages.clone());
        received.select_assign(0, self.senders.clone(), messages.neg(), IndexingUpdateOp::Add)
    }

    /// Sum of the stored edges received at every node.
    pub(crate) fn received_sum(&self, edges: Tensor<2>) -> Tensor<2> {
        let features = edges.dims()[1];
        let zeros = Tensor::zeros([self.nodes, features], &edges.device());
        zeros.select_assign(0, self.receivers.clone(), edges, IndexingUpdateOp::Add)
    }
}
