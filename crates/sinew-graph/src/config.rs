//! Configuration of the augmentation of a graph.

use serde::{Deserialize, Serialize};

/// The inputs η and κ of thesis Algorithm 1, and how k-means is run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AugmentationConfig {
    /// η: virtual nodes of layer 1, 2, …, strictly decreasing. Empty leaves the mesh graph as it is.
    pub roots_per_layer: Vec<usize>,
    /// κ: nearest roots each root is joined to, at most all others, in every layer but the last, which is fully connected.
    pub neighbours: usize,
    /// Seed of the k-means starts.
    pub seed: u64,
    /// k-means starts per layer; the one with the least inertia is kept.
    pub runs: usize,
}

impl AugmentationConfig {
    /// κ of the ventricles and of all scenes of thesis chapter 3.
    const NEIGHBOURS: usize = 5;
    /// Nodes of a tetrahedron: the factor by which thesis §2.2.3 shrinks each layer.
    const SHRINKAGE: usize = 4;
    /// No further layer follows one of at most this many roots. The lists of thesis Table 3.1
    /// end with 24, 14 and 24 roots and go on after 58, so any bound from 24 to 57 gives them.
    const LAST_LAYER: usize = 32;

    /// k-means runs of a mesh on which they are cheap. On the beam of 390 nodes ten instead of
    /// one lower the inertia by 4 % in layer 1 and 6 % in layer 2 (means over 100 seeds).
    const RUNS: usize = 10;
    /// Distances one k-means iteration may evaluate over all runs of the largest layer. It leaves
    /// ten runs to 4000 nodes and one to 21 952, where one takes seconds and gains little.
    const DISTANCES: usize = 45_000_000;

    /// Layers that shrink by four, the last one being the first of at most 32 roots, which are the lists of thesis
    /// Table 3.1.
    ///
    /// A mesh of fewer than four nodes gets no virtual nodes. The seed is 0; set another with
    /// `AugmentationConfig { seed, ..AugmentationConfig::for_nodes(nodes) }`.
    ///
    /// ```
    /// use sinew_graph::AugmentationConfig;
    ///
    /// assert_eq!(AugmentationConfig::for_nodes(390).roots_per_layer, [97, 24]);
    /// assert_eq!(AugmentationConfig::for_nodes(935).roots_per_layer, [233, 58, 14]);
    /// assert_eq!(AugmentationConfig::for_nodes(1570).roots_per_layer, [392, 98, 24]);
    /// ```
    pub fn for_nodes(nodes: usize) -> Self {
        let next = |&roots: &usize| (roots > Self::LAST_LAYER).then_some(roots / Self::SHRINKAGE);
        let first = Some(nodes / Self::SHRINKAGE).filter(|&roots| roots > 0);
        Self::of_layers(nodes, std::iter::successors(first, next).collect())
    }

    /// Layers that shrink by `shrinkage`, down to a single root: clusters within clusters up to the whole body, for
    /// outputs at every scale.
    ///
    /// ```
    /// use sinew_graph::AugmentationConfig;
    ///
    /// assert_eq!(AugmentationConfig::to_one_root(390, 4).roots_per_layer, [97, 24, 6, 1]);
    /// ```
    pub fn to_one_root(nodes: usize, shrinkage: usize) -> Self {
        let next = |&roots: &usize| (roots > 1).then(|| (roots / shrinkage.max(2)).max(1));
        let roots_per_layer = std::iter::successors(next(&nodes), next).collect();
        Self::of_layers(nodes, roots_per_layer)
    }

    /// Layers of so many virtual nodes on a mesh of `nodes` nodes.
    pub fn of_layers(nodes: usize, roots_per_layer: Vec<usize>) -> Self {
        let largest = roots_per_layer.first().copied().unwrap_or(0);
        let per_run = nodes.saturating_mul(largest).max(1);
        let runs = (Self::DISTANCES / per_run).clamp(1, Self::RUNS);
        Self { roots_per_layer, neighbours: Self::NEIGHBOURS, seed: 0, runs }
    }
}
