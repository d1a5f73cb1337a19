//! A topology's edges as the kernels read them.

use crate::fused::{EdgeTopology, GatherPlan, Index};
use sinew_graph::Topology;
use std::collections::HashMap;
use std::hash::Hash;
use std::ops::Range;
use std::sync::Arc;

/// Senders and receivers of the stored half of the edges.
#[derive(Debug, Clone)]
pub struct Graph {
    /// Nodes of each layer, the real ones first.
    pub(crate) layers: Vec<Range<usize>>,
    pub(crate) edges: Arc<EdgeTopology>,
    /// Kind of every node and edge, of which some may be equal: tables of features have a row of each kind.
    pub(crate) kinds: [Arc<Index>; 2],
    /// Different messages of the first step, from a table of each kind, and the kind of every message; those of later steps.
    pub(crate) plans: [(Arc<GatherPlan>, Arc<Index>); 2],
}

impl Graph {
    /// Graph of a topology's edges.
    ///
    /// # Panics
    /// When an edge ends at a node that does not exist ([`Topology::validate`]).
    pub fn new(topology: &Topology) -> Self {
        Self::of_kinds(topology, [topology.nodes, topology.senders.len()].map(|n| kinds(0..n)))
    }

    /// Graph of nodes and edges of these kinds. Regular meshes have few kinds of edges, and of first messages.
    pub(crate) fn of_kinds(topology: &Topology, [nodes, edges]: [Arc<Index>; 2]) -> Self {
        let kind = |node: &usize| nodes.targets[*node] as usize;
        let ends = topology.receivers.iter().zip(&topology.senders).zip(&edges.targets);
        let triple = |((r, s), edge): ((&usize, &usize), &u32)| [*edge as usize, kind(r), kind(s)];
        let all: Vec<_> = ends.map(triple).collect();
        // Where all edges differ, so do messages.
        let differ = edges.inverse.len() == edges.targets.len();
        let messages = if differ { edges.clone() } else { kinds(all.iter()) };
        let first: Vec<_> = messages.inverse.iter().map(|edges| all[edges[0]]).collect();
        let counts = [&edges, &nodes, &nodes].map(|kinds| kinds.inverse.len());
        let (first, kinds) = ((GatherPlan::triples(&first, counts), messages), [nodes, edges]);
        let layers = (0..=topology.clusters.len()).map(|layer| topology.layer(layer)).collect();
        let edges = EdgeTopology::new(topology.nodes, &topology.senders, &topology.receivers);
        let later = (GatherPlan::edges(&edges), Arc::default());
        Self { layers, edges, kinds, plans: [first, later] }
    }
}

/// Number of the kind of every row, where rows with equal keys are of one kind.
pub(crate) fn kinds<K: Eq + Hash>(keys: impl Iterator<Item = K>) -> Arc<Index> {
    let mut known = HashMap::new();
    let kind = |key| {
        let next = known.len();
        *known.entry(key).or_insert(next)
    };
    let kinds: Vec<usize> = keys.map(kind).collect();
    Index::new(&kinds, known.len()).into()
}
