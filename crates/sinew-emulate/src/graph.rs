//! The graph of a body, with its clusters.

use crate::{Body, Result};
use sinew_graph::{AugmentationConfig, Topology, augment};

/// Clusters per cluster of the next layer, up to the whole body (docs/design.md, "Graph").
const SHRINKAGE: usize = 2;

/// Augmented graph of a body (thesis Algorithm 1). Bodies of one connectivity may share it. `to_one_root` halves the number
/// of clusters from layer to layer until one covers the whole body.
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

/// Graph of an unseen body, up to one root. k-means starts once: ten starts would take longer than everything else.
///
/// # Errors
/// As [`topology`].
pub fn topology_of_met(body: &Body, seed: u64) -> Result<Topology> {
    let config = AugmentationConfig::to_one_root(body.nodes, SHRINKAGE);
    let config = AugmentationConfig { seed, runs: 1, ..config };
    Ok(augment(&body.positions, &body.mesh.edges(), &config)?)
}
