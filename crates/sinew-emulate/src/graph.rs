//! The graph of a body: what every network starts from.

use crate::{Body, Result};
use sinew_gnn::{Dirichlet, Geometry};
use sinew_graph::{AugmentationConfig, FeatureMatrix, Topology, augment, graph_features};

/// Augmented graph and features of a body (thesis Algorithm 1): the indicator of the Dirichlet boundary
/// on the nodes, difference and distance of positions on the edges.
///
/// # Errors
/// A mesh that has no valid graph, or supports that networks cannot keep.
pub(crate) fn geometry(body: &Body, seed: u64) -> Result<(Topology, Geometry)> {
    let nodes = body.nodes;
    let config = AugmentationConfig { seed, ..AugmentationConfig::for_nodes(nodes) };
    let topology = augment(&body.positions, &body.mesh.edges(), &config)?;
    let held = body.prescribed.chunks_exact(3).enumerate();
    let held: Vec<usize> =
        held.filter(|(_, row)| row.iter().all(Option::is_some)).map(|(node, _)| node).collect();
    let indicator = FeatureMatrix::indicator(nodes, &held)?;
    let features = graph_features(&topology, &body.positions, &indicator, 3)?;
    let dirichlet = Dirichlet::of_body(body)?;
    Ok((topology, Geometry { features, global: Vec::new(), dirichlet, basis: None }))
}
