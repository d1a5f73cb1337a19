//! Sums of edge messages at the nodes of a graph.

use crate::fused::error::IndexError;
use crate::fused::host::{Cotangents, HostOperation, HostTensor, apply, is_on_host};
use crate::fused::index::{Gather, GatherPlan, check, inverse};
use crate::fused::reference;
use crate::fused::rows::add_up;
use burn::tensor::Tensor;
use rayon::prelude::*;
use std::sync::Arc;

/// Edges treated by one task; small graphs are not worth more.
const EDGES_PER_TASK: usize = 64;

/// Directed edges of a graph, with the lists of edges that each node receives and sends.
///
/// Built once per graph and shared by every operation on it.
#[derive(Debug)]
pub struct EdgeTopology {
    pub(super) nodes: usize,
    pub(super) senders: Vec<u32>,
    pub(super) receivers: Vec<u32>,
    received: Vec<Vec<usize>>,
    sent: Vec<Vec<usize>>,
}

impl EdgeTopology {
    /// Edge `i` goes from node `senders[i]` to node `receivers[i]`, both below `nodes`.
    pub fn new(
        nodes: usize,
        senders: &[usize],
        receivers: &[usize],
    ) -> Result<Arc<Self>, IndexError> {
        if senders.len() != receivers.len() {
            let [senders, receivers] = [senders, receivers].map(<[usize]>::len);
            return Err(IndexError::UnpairedEdges { senders, receivers });
        }
        let (senders, receivers) = (check(senders, nodes)?, check(receivers, nodes)?);
        let (received, sent) = (inverse(&receivers, nodes), inverse(&senders, nodes));
        Ok(Arc::new(Self { nodes, senders, receivers, received, sent }))
    }

    /// Numbers of nodes and of edges.
    pub fn size(&self) -> [usize; 2] {
        [self.nodes, self.senders.len()]
    }
}

impl GatherPlan {
    /// One row per edge, from three sources: a row per edge, and two sources of a row per node,
    /// read at the receiving and at the sending node.
    pub fn edges(topology: &EdgeTopology) -> Arc<Self> {
        let EdgeTopology { nodes, senders, receivers, received, sent } = topology;
        let read_at = |index: &Vec<u32>, inverse: &Vec<_>| Gather::Indexed {
            index: index.clone(),
            inverse: inverse.clone(),
        };
        let (receiver, sender) = (read_at(receivers, received), read_at(senders, sent));
        let (edges, nodes) = (senders.len(), *nodes);
        Arc::new(Self {
            rows: edges,
            sources: vec![Gather::Identity, receiver, sender],
            source_rows: vec![edges, nodes, nodes],
        })
    }
}

/// Per node, the sum of the messages it receives minus the sum of those it sends:
/// `[edges, k]` to `[nodes, k]` (thesis, Algorithm 2).
///
/// # Panics
/// When `messages` has not one row per edge.
pub fn signed_edge_sum(messages: Tensor<2>, topology: &Arc<EdgeTopology>) -> Tensor<2> {
    sum(messages, topology, true)
}

/// Per node, the sum of the messages it receives: `[edges, k]` to `[nodes, k]`.
///
/// # Panics
/// When `messages` has not one row per edge.
pub fn received_edge_sum(messages: Tensor<2>, topology: &Arc<EdgeTopology>) -> Tensor<2> {
    sum(messages, topology, false)
}

fn sum(messages: Tensor<2>, topology: &Arc<EdgeTopology>, signed: bool) -> Tensor<2> {
    let [edges, width] = messages.dims();
    assert_eq!(edges, topology.senders.len(), "messages must have one row per edge");
    if !is_on_host(&messages) || width == 0 {
        return match signed {
            true => reference::signed_edge_sum(messages, topology),
            false => reference::received_edge_sum(messages, topology),
        };
    }
    apply(EdgeSum { topology: topology.clone(), signed }, vec![messages.into_dispatch()])
}

#[derive(Clone, Debug)]
struct EdgeSum {
    topology: Arc<EdgeTopology>,
    /// Whether sent messages count, negatively.
    signed: bool,
}

impl HostOperation for EdgeSum {
    type Saved = usize;

    fn forward(&self, inputs: &[HostTensor], _tracked: bool) -> (HostTensor, Option<usize>) {
        let (messages, width) = (inputs[0].values(), inputs[0].last_dimension());
        let mut sums = vec![0.0; self.topology.nodes * width];
        add_up(messages, &self.topology.received, 1.0, width, &mut sums);
        if self.signed {
            add_up(messages, &self.topology.sent, -1.0, width, &mut sums);
        }
        (HostTensor::new(sums, [self.topology.nodes, width]), Some(width))
    }

    fn backward(&self, width: usize, cotangent: &[f32], _needed: &[bool]) -> Cotangents {
        let mut gradient = vec![0.0; self.topology.senders.len() * width];
        let edges = gradient.par_chunks_exact_mut(width).enumerate().with_min_len(EDGES_PER_TASK);
        edges.for_each(|(edge, gradient)| {
            gradient.copy_from_slice(row(cotangent, self.topology.receivers[edge], width));
            if self.signed {
                let sent = row(cotangent, self.topology.senders[edge], width);
                gradient.iter_mut().zip(sent).for_each(|(sum, value)| *sum -= value);
            }
        });
        vec![Some(gradient)]
    }
}

fn row(values: &[f32], index: u32, width: usize) -> &[f32] {
    &values[index as usize * width..][..width]
}
