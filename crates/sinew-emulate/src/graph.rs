//! The graph of a body, with its clusters.

use crate::{Body, Result};
use sinew_graph::{AugmentationConfig, Topology, augment};

/// Clusters of a layer in one of the next, where they go on to the whole body (docs/design.md, "Graph").
const SHRINKAGE: usize = 2;

/// Augmented graph of a body (thesis Algorithm 1), which bodies of one connectivity may share. `to_one_root` continues the clusters, halving
/// them, up to the whole body.
///
/// # Errors
/// A mesh that has no valid graph.
pub fn topology(body: &Body, to_one_root: bool, seed: u64) -> Result<Topology> {
    let config = match to_one_root {
        true => AugmentationConfig::to_one_root(body.nodes, SHRINKAGE),
        false => AugmentationConfig::for_nodes(body.nodes),
    };
    let config = AugmentationConfig { seed, ..config };
    Ok(augment(&body.positions, &body.mesh.edges(), &config)?)
}

/// The graph of a body that is met, not trained on: up to the whole body, by one start of k-means, where ten take longer than all else.
///
/// # Errors
/// As [`topology`].
pub fn topology_of_met(body: &Body, seed: u64) -> Result<Topology> {
    let config = AugmentationConfig::to_one_root(body.nodes, SHRINKAGE);
    let config = AugmentationConfig { seed, runs: 1, ..config };
    Ok(augment(&body.positions, &body.mesh.edges(), &config)?)
}
