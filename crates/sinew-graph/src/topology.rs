//! Nodes, edges and clusters of an augmented graph.

use crate::GraphError;
use serde::{Deserialize, Serialize};
use sinew_num::{ascending, connected_components};
use std::ops::Range;

/// The augmented graph of thesis Algorithm 1, without positions: geometries whose meshes have
/// the same connectivity share one.
///
/// Node indices run over the mesh nodes, then the roots of layer 1, then those of layer 2, and
/// so on. Every relation stands for a pair of directed edges and is stored once, with
/// `sender > receiver` (thesis Eq. 2.22); edges are sorted by sender, then receiver, so those
/// of the mesh come first. [`crate::augment`] makes valid ones; after reading or changing one call [`Topology::validate`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Topology {
    /// Nodes of the mesh.
    pub real_nodes: usize,
    /// All nodes, virtual ones included.
    pub nodes: usize,
    /// The end of each edge with the larger node index.
    pub senders: Vec<usize>,
    /// The end of each edge with the smaller node index.
    pub receivers: Vec<usize>,
    /// Virtual nodes of layer 1, 2, ….
    pub roots_per_layer: Vec<usize>,
    /// `clusters[l][i]` is the root of leaf `i`, both counted from 0 within their layers:
    /// leaves in layer `l` (0 are the mesh nodes), roots in layer `l + 1`.
    pub clusters: Vec<Vec<usize>>,
}

impl Topology {
    /// Nodes of one layer: 0 are the mesh nodes, `l ≥ 1` the roots of layer `l`.
    ///
    /// # Panics
    /// When there is no such layer.
    pub fn layer(&self, layer: usize) -> Range<usize> {
        let size = |l: usize| if l == 0 { self.real_nodes } else { self.roots_per_layer[l - 1] };
        let start = (0..layer).map(size).sum();
        start..start + size(layer)
    }

    /// The edges as `[sender, receiver]`.
    pub fn edges(&self) -> impl ExactSizeIterator<Item = [usize; 2]> {
        self.senders.iter().zip(&self.receivers).map(|(&sender, &receiver)| [sender, receiver])
    }

    /// Checks counts, clusters and edges, and that all nodes are connected.
    ///
    /// # Errors
    /// The first promise broken.
    pub fn validate(&self) -> Result<(), GraphError> {
        self.validate_clusters()?;
        self.validate_edges()?;
        let components = connected_components(self.nodes, self.edges());
        let sizes = || components.iter().map(Vec::len);
        let [largest, smallest] = [sizes().max(), sizes().min()].map(Option::unwrap_or_default);
        ensure!(
            components.len() < 2,
            "the graph falls into {} parts of {largest} down to {smallest} nodes: merge coincident nodes, drop nodes no cell uses, or add a layer of virtual nodes to join them",
            components.len()
        );
        Ok(())
    }

    /// Counts of nodes and clusters, every leaf with a root and every root with a leaf.
    pub(crate) fn validate_clusters(&self) -> Result<(), GraphError> {
        let virtual_nodes = self.roots_per_layer.iter().try_fold(0usize, |n, &r| n.checked_add(r));
        let nodes = virtual_nodes.and_then(|n| n.checked_add(self.real_nodes));
        count("nodes", nodes.unwrap_or(usize::MAX), self.nodes)?;
        count("layers of clusters", self.roots_per_layer.len(), self.clusters.len())?;
        let mut leaves = self.real_nodes;
        for (layer, (clusters, &roots)) in
            self.clusters.iter().zip(&self.roots_per_layer).enumerate()
        {
            count("leaves", leaves, clusters.len())?;
            for (leaf, &root) in clusters.iter().enumerate() {
                ensure!(
                    root < roots,
                    "leaf {leaf} of layer {layer} names root {root}, the layer above has {roots}"
                );
            }
            let used = ascending(clusters.iter().copied());
            for root in 0..roots {
                ensure!(
                    used.get(root) == Some(&root),
                    "root {root} of layer {} has no leaves: its features would be undefined",
                    layer + 1
                );
            }
            leaves = roots;
        }
        Ok(())
    }

    fn validate_edges(&self) -> Result<(), GraphError> {
        count("receivers", self.senders.len(), self.receivers.len())?;
        let mut before = [0, 0];
        for (edge, [sender, receiver]) in self.edges().enumerate() {
            ensure!(
                sender < self.nodes && receiver < sender,
                "edge {edge} runs from {sender} to {receiver} in a graph of {} nodes: senders must exist and exceed their receivers, a pair is stored once",
                self.nodes
            );
            ensure!(
                edge == 0 || before < [sender, receiver],
                "edge {edge} does not follow its predecessor in order: sort the edges, drop repeats"
            );
            before = [sender, receiver];
        }
        Ok(())
    }
}

fn count(what: &'static str, expected: usize, found: usize) -> Result<(), GraphError> {
    ensure!(
        expected == found,
        "{what}: {expected} expected, {found} found; build the topology with `augment`"
    );
    Ok(())
}
