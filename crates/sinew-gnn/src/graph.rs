//! A topology's edges as the kernels read them.

use crate::fused::{EdgeTopology, GatherPlan, Index, selected};
use burn::tensor::Tensor;
use sinew_graph::{FeatureMatrix, GraphFeatures, Topology};
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
    pub(crate) plan: Arc<GatherPlan>,
    /// Nodes and edges by their features, and first messages by what they are functions of.
    pub(crate) kinds: [Kinds; 3],
    /// A first message of each kind, from those of edges, and those of nodes for receivers and senders.
    pub(crate) first: Arc<GatherPlan>,
}

impl Graph {
    /// Graph of a topology's edges.
    ///
    /// # Panics
    /// When an edge ends at a node that does not exist ([`Topology::validate`]).
    pub fn new(topology: &Topology) -> Self {
        Self::of_kinds(topology, [Kinds(None), Kinds(None)])
    }

    /// Graph for these features alone: equal rows are encoded once, and so are equal messages of the first step. Regular
    /// meshes have few kinds of edges.
    pub(crate) fn with_features(topology: &Topology, features: &GraphFeatures) -> Self {
        let kinds = |table: &FeatureMatrix| {
            let bits: Vec<u32> = table.values.iter().map(|x| (*x as f32).to_bits()).collect();
            Kinds::of(bits.chunks_exact(table.columns))
        };
        Self::of_kinds(topology, [kinds(&features.nodes), kinds(&features.edges)])
    }

    fn of_kinds(topology: &Topology, [nodes, edges]: [Kinds; 2]) -> Self {
        let Topology { senders, receivers, .. } = topology;
        let layers = (0..=topology.clusters.len()).map(|layer| topology.layer(layer)).collect();
        let ends = receivers.iter().zip(senders).enumerate();
        let read = |(edge, (receiver, sender)): (usize, (&usize, &usize))| {
            [edges.kind(edge), nodes.kind(*receiver), nodes.kind(*sender)]
        };
        let mut read: Vec<_> = ends.map(read).collect();
        let of_nodes = nodes.count(topology.nodes);
        let counts = [edges.count(read.len()), of_nodes, of_nodes];
        // Where all edges differ, so do messages.
        let messages = edges.0.as_ref().map_or(Kinds(None), |_| Kinds::of(read.iter()));
        if let Some([examples, _]) = &messages.0 {
            read = examples.targets.iter().map(|edge| read[*edge as usize]).collect();
        }
        let topology = EdgeTopology::new(topology.nodes, senders, receivers);
        let (plan, first) = (GatherPlan::edges(&topology), GatherPlan::triples(&read, counts));
        Self { layers, plan, edges: topology, kinds: [nodes, edges, messages], first }
    }
}

/// The first row of each kind of the rows of a table, and the kind of every row; none where all rows differ.
#[derive(Debug, Clone)]
pub(crate) struct Kinds(Option<[Arc<Index>; 2]>);

impl Kinds {
    /// Rows with equal keys are of one kind.
    fn of<K: Eq + Hash>(keys: impl Iterator<Item = K>) -> Self {
        let (mut known, mut examples) = (HashMap::new(), Vec::new());
        let kind = |(row, key)| {
            *known.entry(key).or_insert_with(|| {
                examples.push(row);
                examples.len() - 1
            })
        };
        let kinds: Vec<usize> = keys.enumerate().map(kind).collect();
        let indices = || [(&examples, kinds.len()), (&kinds, examples.len())];
        let index = |(targets, count): (&Vec<usize>, usize)| Index::new(targets, count).into();
        Self((examples.len() < kinds.len()).then(|| indices().map(index)))
    }

    fn kind(&self, row: usize) -> usize {
        self.0.as_ref().map_or(row, |[_, kinds]| kinds.targets[row] as usize)
    }

    /// Number of kinds of `rows` rows.
    fn count(&self, rows: usize) -> usize {
        self.0.as_ref().map_or(rows, |[examples, _]| examples.targets.len())
    }

    /// A row of each kind.
    pub(crate) fn examples(&self, table: Tensor<2>) -> Tensor<2> {
        self.0.iter().fold(table, |table, [examples, _]| selected(table, examples))
    }

    /// All rows, from one of each kind.
    pub(crate) fn rows(&self, examples: Tensor<2>) -> Tensor<2> {
        self.0.iter().fold(examples, |examples, [_, kinds]| selected(examples, kinds))
    }
}
