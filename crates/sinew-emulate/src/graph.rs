//! The graph of a body: what every network starts from.

use crate::{Body, Result};
use sinew_gnn::{Coordinates, Dirichlet, Geometry};
use sinew_graph::{AugmentationConfig, FeatureMatrix, augment, graph_features};

/// Clusters of a layer in one of the next, where they go on to the whole body: measured in docs/design.md.
const SHRINKAGE: usize = 2;

/// Augmented graph and features of a body (thesis Algorithm 1): the indicator of the Dirichlet boundary
/// on the nodes, difference and distance of positions on the edges. `to_one_root` continues the clusters, halving them, up to the whole
/// body.
///
/// # Errors
/// A mesh that has no valid graph.
pub(crate) fn geometry(body: &Body, to_one_root: bool, seed: u64) -> Result<Geometry> {
    let nodes = body.nodes;
    let config = match to_one_root {
        true => AugmentationConfig::to_one_root(nodes, SHRINKAGE),
        false => AugmentationConfig::for_nodes(nodes),
    };
    let config = AugmentationConfig { seed, ..config };
    let topology = augment(&body.positions, &body.mesh.edges(), &config)?;
    let held = body.prescribed.chunks_exact(3).enumerate();
    let held: Vec<usize> =
        held.filter(|(_, row)| row.iter().all(Option::is_some)).map(|(node, _)| node).collect();
    let indicator = FeatureMatrix::indicator(nodes, &held)?;
    let features = graph_features(&topology, &body.positions, &indicator, 3)?;
    let (dirichlet, coordinates) = (Dirichlet::of_body(body), Coordinates::Components);
    Ok(Geometry { topology, features, global: Vec::new(), dirichlet, coordinates })
}
