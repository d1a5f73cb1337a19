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
    pub(super) senders: Arc<Index>,
    pub(super) receivers: Arc<Index>,
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
        let [senders, receivers] = [senders, receivers].map(|ends| Index::new(ends, nodes).into());
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
        let ends = topology.receivers.targets.iter().zip(&topology.senders.targets).enumerate();
        let triple = |(edge, (r, s)): (usize, (&u32, &u32))| [edge, *r as usize, *s as usize];
        Self::triples(&ends.map(triple).collect::<Vec<_>>(), [edges, nodes, nodes])
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
    let parts = [(1.0, topology.receivers.clone()), (-1.0, topology.senders.clone())];
    let parts = parts[..1 + usize::from(signed)].to_vec();
    Gathers { parts, width }.apply(messages, true)
}

/// Rows of `table` that the entries of `index` refer to, as one operation: some in ascending order, or repeated ones in that of their first
/// entries. As many rows as the table has are the table itself.
pub(crate) fn selected(table: Tensor<2>, index: &Arc<Index>) -> Tensor<2> {
    match index.targets.len() == index.inverse.len() {
        true => table,
        false if !is_on_host(&table) => reference::selected(table, index),
        false => {
            let gathers = Gathers { parts: vec![(1.0, index.clone())], width: table.dims()[1] };
            gathers.apply(table, false)
        }
    }
}

/// Signed sum of gathers of rows of this width.
#[derive(Clone)]
struct Gathers {
    parts: Vec<(f32, Arc<Index>)>,
    width: usize,
}

impl Gathers {
    /// Sums of the rows of a table that the entries refer to, or the transpose of this map.
    fn map(&self, table: &[f32], transposed: bool) -> Vec<f32> {
        let (index, width) = (&self.parts[0].1, self.width);
        let count = if transposed { index.inverse.len() } else { index.targets.len() };
        let mut sums = vec![0.0; count * width];
        if transposed {
            let parts = self.parts.iter();
            parts.for_each(|(s, index)| add_up(table, &index.inverse, *s, width, &mut sums));
            return sums;
        }
        let rows = sums.par_chunks_exact_mut(width).enumerate().with_min_len(EDGES_PER_TASK);
        rows.for_each(|(row, sum)| {
            for (sign, index) in &self.parts {
                let from = &table[index.targets[row] as usize * width..];
                sum.iter_mut().zip(from).for_each(|(sum, x)| *sum += sign * x);
            }
        });
        sums
    }

    /// The map as one operation, whose derivative is its transpose.
    fn apply(self, x: Tensor<2>, transposed: bool) -> Tensor<2> {
        apply(vec![x.into_dispatch()], move |inputs, _| {
            let (rows, back) = (self.map(inputs[0].values(), transposed), self.clone());
            let shape = [rows.len() / self.width, self.width];
            let pull =
                move |cotangent: &[f32], _: &[bool]| vec![Some(back.map(cotangent, !transposed))];
            (HostTensor::new(rows, shape), Pullback::new(pull))
        })
    }
}
