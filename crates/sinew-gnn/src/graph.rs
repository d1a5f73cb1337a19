//! A topology's edges as the kernels read them.

use crate::fused::{EdgeTopology, GatherPlan};
use sinew_graph::Topology;
use std::ops::Range;
use std::sync::Arc;

/// Senders and receivers of the stored half of the edges.
#[derive(Debug, Clone)]
pub struct Graph {
    /// Nodes of each layer, the real ones first.
    pub(crate) layers: Vec<Range<usize>>,
    pub(crate) edges: Arc<EdgeTopology>,
    pub(crate) plan: Arc<GatherPlan>,
}

impl Graph {
    /// Graph of a topology's edges.
    ///
    /// # Panics
    /// When an edge ends at a node that does not exist ([`Topology::validate`]).
    pub fn new(topology: &Topology) -> Self {
        let edges = EdgeTopology::new(topology.nodes, &topology.senders, &topology.receivers);
        let layers = (0..=topology.clusters.len()).map(|layer| topology.layer(layer)).collect();
        Self { layers, plan: GatherPlan::edges(&edges), edges }
    }
}
