//! Graph and features of a body: what every network starts from.

use crate::Result;
use sinew_coordinates::{Coordinates, Dirichlet, Motions};
use sinew_emulate::Body;
use sinew_emulate::parts::topology;
use sinew_gnn::Geometry;
use sinew_graph::{FeatureMatrix, Topology, graph_features};

/// Augmented graph and features of a body (thesis Algorithm 1): the indicator of the Dirichlet boundary
/// on the nodes, difference and distance of positions on the edges. `to_one_root` continues the clusters, halving them, up to the whole
/// body.
///
/// # Errors
/// A mesh that has no valid graph.
pub(crate) fn geometry(body: &Body, to_one_root: bool, seed: u64) -> Result<Geometry> {
    geometry_at(&body.positions, body, topology(body, to_one_root, seed)?)
}

/// Features of a body on a graph of its connectivity, its nodes at these positions.
pub(crate) fn geometry_at(
    positions: &[[f64; 3]],
    body: &Body,
    topology: Topology,
) -> Result<Geometry> {
    let nodes = body.nodes;
    let held = body.prescribed.chunks_exact(3).enumerate();
    let held: Vec<usize> =
        held.filter(|(_, row)| row.iter().all(Option::is_some)).map(|(node, _)| node).collect();
    let indicator = FeatureMatrix::indicator(nodes, &held)?;
    let features = graph_features(&topology, positions, &indicator, 3)?;
    let (dirichlet, coordinates) = (Dirichlet::of_body(body), Coordinates::Components);
    Ok(Geometry { topology, features, global: Vec::new(), dirichlet, coordinates })
}

/// Appends the Taylor coefficients of the outputs to the features of the nodes.
pub(crate) fn add_features(geometry: &mut Geometry, motions: &Motions) -> Result<()> {
    let nodes = &mut geometry.features.nodes;
    *nodes = nodes.hstack(&motions.features())?;
    Ok(())
}
