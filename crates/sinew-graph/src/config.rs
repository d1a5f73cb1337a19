//! How a graph is augmented.

use serde::{Deserialize, Serialize};

/// The inputs η and κ of thesis Algorithm 1, and how k-means is run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AugmentationConfig {
    /// η: virtual nodes of layer 1, 2, …, strictly decreasing. Empty leaves the mesh graph as it is.
    pub roots_per_layer: Vec<usize>,
    /// κ: nearest roots each root is joined to, in every layer but the last, which is fully connected.
    pub neighbours: usize,
    /// Seed of the k-means starts.
    pub seed: u64,
    /// k-means starts per layer; the one with the least inertia is kept.
    pub runs: usize,
}

impl AugmentationConfig {
    /// κ of the ventricles and of all scenes of thesis chapter 3.
    pub const NEIGHBOURS: usize = 5;
    /// Nodes of a tetrahedron: the factor by which thesis §2.2.3 shrinks each layer.
    pub const SHRINKAGE: usize = 4;
    /// No further layer follows one of at most this many roots. The lists of thesis Table 3.1
    /// end with 24, 14 and 24 roots and go on after 58, so any bound from 24 to 57 gives them.
    pub const LAST_LAYER: usize = 32;

    /// Layers that shrink by [`Self::SHRINKAGE`], the last one being the first of at most
    /// [`Self::LAST_LAYER`] roots, which are the lists of thesis Table 3.1; seed 0.
    ///
    /// A mesh of fewer than four nodes gets no virtual nodes.
    ///
    /// ```
    /// use sinew_graph::AugmentationConfig;
    ///
    /// assert_eq!(AugmentationConfig::for_nodes(390).roots_per_layer, [97, 24]);
    /// assert_eq!(AugmentationConfig::for_nodes(935).roots_per_layer, [233, 58, 14]);
    /// assert_eq!(AugmentationConfig::for_nodes(1570).roots_per_layer, [392, 98, 24]);
    /// ```
    pub fn for_nodes(nodes: usize) -> Self {
        let mut roots_per_layer = Vec::new();
        let mut roots = nodes / Self::SHRINKAGE;
        while roots > 0 {
            roots_per_layer.push(roots);
            if roots <= Self::LAST_LAYER {
                break;
            }
            roots /= Self::SHRINKAGE;
        }
        Self { roots_per_layer, neighbours: Self::NEIGHBOURS, seed: 0, runs: 10 }
    }
}
