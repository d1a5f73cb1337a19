//! Sums of edge messages at the nodes of a graph.

use crate::fused::host::{HostTensor, Pullback, apply, is_on_host};
use crate::fused::index::{Gather, GatherPlan, Index};
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
    pub(super) senders: Index,
    pub(super) receivers: Index,
}

impl EdgeTopology {
    /// Edge `i` goes from node `senders[i]` to node `receivers[i]`, both below `nodes`.
    ///
    /// # Panics
    /// When there are not as many senders as receivers, or one of them does not exist.
    pub fn new(nodes: usize, senders: &[usize], receivers: &[usize]) -> Arc<Self> {
        assert_eq!(senders.len(), receivers.len(), "senders and receivers of edges");
        let beyond = senders.iter().chain(receivers).find(|node| **node >= nodes);
        assert_eq!(beyond, None, "an end of an edge beyond the {nodes} nodes");
        let [senders, receivers] = [senders, receivers].map(|ends| Index::new(ends, nodes));
        Arc::new(Self { nodes, senders, receivers })
    }

    /// Numbers of nodes and of edges.
    pub fn size(&self) -> [usize; 2] {
        [self.nodes, self.senders.targets.len()]
    }
}

impl GatherPlan {
    /// One row per edge, from three sources: a row per edge, and two sources of a row per node,
    /// read at the receiving and at the sending node.
    pub fn edges(topology: &EdgeTopology) -> Arc<Self> {
        let [nodes, edges] = topology.size();
        let of_nodes = |index: &Index| (Gather::Indexed(index.clone()), nodes);
        let (receivers, senders) = (of_nodes(&topology.receivers), of_nodes(&topology.senders));
        Arc::new(Self { rows: edges, sources: vec![(Gather::Identity, edges), receivers, senders] })
    }

    /// One row per triple of rows of three sources, which have `counts` rows.
    pub(crate) fn triples(triples: &[[usize; 3]], counts: [usize; 3]) -> Arc<Self> {
        let source = |part: usize| {
            let (rows, count) = (triples.iter().map(|triple| triple[part]), counts[part]);
            let indexed = || Gather::Indexed(Index::new(&rows.clone().collect::<Vec<_>>(), count));
            (if rows.clone().eq(0..count) { Gather::Identity } else { indexed() }, count)
        };
        Arc::new(Self { rows: triples.len(), sources: (0..3).map(source).collect() })
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
    assert_eq!(edges, topology.size()[1], "messages must have one row per edge");
    if !is_on_host(&messages) || width == 0 {
        return match signed {
            true => reference::signed_edge_sum(messages, topology),
            false => reference::received_edge_sum(messages, topology),
        };
    }
    let topology = topology.clone();
    apply(vec![messages.into_dispatch()], move |inputs, _| {
        let messages = inputs[0].values();
        let mut sums = vec![0.0; topology.nodes * width];
        add_up(messages, &topology.receivers.inverse, 1.0, width, &mut sums);
        if signed {
            add_up(messages, &topology.senders.inverse, -1.0, width, &mut sums);
        }
        let output = HostTensor::new(sums, [topology.nodes, width]);
        let topology = topology.clone();
        let pullback = Pullback::new(move |cotangent, _| {
            vec![Some(differences(&topology, signed, width, cotangent))]
        });
        (output, pullback)
    })
}

/// Cotangents of the edges' messages from those of the nodes' sums.
fn differences(topology: &EdgeTopology, signed: bool, width: usize, cotangent: &[f32]) -> Vec<f32> {
    let of_node = |node: u32| &cotangent[node as usize * width..][..width];
    let mut gradient = vec![0.0; topology.size()[1] * width];
    let edges = gradient.par_chunks_exact_mut(width).enumerate().with_min_len(EDGES_PER_TASK);
    edges.for_each(|(edge, gradient)| {
        gradient.copy_from_slice(of_node(topology.receivers.targets[edge]));
        if signed {
            let sent = of_node(topology.senders.targets[edge]);
            gradient.iter_mut().zip(sent).for_each(|(sum, value)| *sum -= value);
        }
    });
    gradient
}
