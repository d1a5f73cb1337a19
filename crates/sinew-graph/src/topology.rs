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
/// of the mesh come first. [`crate::augment`] makes valid ones, deserialising checks;
/// after changing one by hand call [`Topology::validate`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedTopology")]
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

    /// Checks every promise of this type, among them that all nodes are connected.
    ///
    /// # Errors
    /// The first promise broken.
    pub fn validate(&self) -> Result<(), GraphError> {
        self.validate_clusters()?;
        self.validate_edges()?;
        self.validate_layers()?;
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

    /// Edges that the clusters ask for, ascending: from each root to its leaves, and all between roots of the last layer.
    pub(crate) fn edges_of_clusters(&self) -> Vec<[usize; 2]> {
        let mut edges = Vec::new();
        for (layer, clusters) in self.clusters.iter().enumerate() {
            let start = self.layer(layer + 1).start;
            edges.extend(self.layer(layer).zip(clusters).map(|(leaf, root)| [start + root, leaf]));
        }
        if !self.clusters.is_empty() {
            let last = self.layer(self.clusters.len());
            let below = |larger| (last.start..larger).map(move |smaller| [larger, smaller]);
            edges.extend(last.clone().flat_map(below));
        }
        ascending(edges)
    }

    /// No other edges than those of the clusters are between layers or in the last one.
    fn validate_layers(&self) -> Result<(), GraphError> {
        let layers = self.roots_per_layer.len();
        let layer_of: Vec<usize> =
            (0..=layers).flat_map(|l| std::iter::repeat_n(l, self.layer(l).len())).collect();
        // A file may claim more roots than pairs of them fit in memory.
        let roots = self.roots_per_layer.last().copied().unwrap_or_default();
        let pairs = roots.saturating_mul(roots.saturating_sub(1)) / 2;
        ensure!(
            pairs <= self.senders.len(),
            "the {roots} roots of the last layer need {pairs} edges among them, and the graph has {} in all",
            self.senders.len()
        );
        let wanted = self.edges_of_clusters();
        for [sender, receiver] in self.edges() {
            let [from, to] = [sender, receiver].map(|node| layer_of[node]);
            ensure!(
                from == to || wanted.binary_search(&[sender, receiver]).is_ok(),
                "node {receiver} of layer {to} is joined to node {sender} of layer {from}, which is not its root: between layers a node is joined to its root only"
            );
        }
        let edges: Vec<_> = self.edges().collect();
        for edge @ [root, node] in wanted {
            ensure!(
                edges.binary_search(&edge).is_ok(),
                "node {node} is not joined to node {root}: each node needs its root, and a root of the last layer all others there"
            );
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

/// Content of a file before it is checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct UncheckedTopology {
    real_nodes: usize,
    nodes: usize,
    senders: Vec<usize>,
    receivers: Vec<usize>,
    roots_per_layer: Vec<usize>,
    clusters: Vec<Vec<usize>>,
}

impl TryFrom<UncheckedTopology> for Topology {
    type Error = GraphError;

    fn try_from(read: UncheckedTopology) -> Result<Self, GraphError> {
        let UncheckedTopology { real_nodes, nodes, senders, receivers, roots_per_layer, clusters } =
            read;
        // Before anything is allocated for a number of nodes that only the file claims.
        ensure!(
            senders.len() >= nodes.saturating_sub(1),
            "{} edges cannot connect {nodes} nodes: is the file complete?",
            senders.len()
        );
        let topology = Self { real_nodes, nodes, senders, receivers, roots_per_layer, clusters };
        topology.validate()?;
        Ok(topology)
    }
}
