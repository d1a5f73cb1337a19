//! The graph of a scene: what every emulator of it starts from.

use anyhow::{Context, Result};
use sinew_gnn::{Coordinates, Dirichlet, Geometry};
use sinew_graph::{AugmentationConfig, FeatureMatrix, Topology, augment, graph_features};
use sinew_mesh::TetMesh;

/// Augmented graph and features of a body (thesis Algorithm 1): the indicator of the Dirichlet boundary
/// on the nodes, difference and distance of positions on the edges.
///
/// # Errors
/// A mesh that has no valid graph, or supports along other directions than the coordinate axes.
pub fn geometry(
    mesh: &TetMesh,
    potential: &sinew_energy::Body,
    config: AugmentationConfig,
) -> Result<(Topology, Geometry)> {
    let nodes = mesh.points.len();
    let topology = augment(&mesh.points, &sinew_mesh::edges(mesh), &config)
        .context("the mesh could not be turned into a graph")?;
    let held = potential.prescribed.chunks_exact(3).enumerate();
    let held: Vec<usize> =
        held.filter(|(_, row)| row.iter().all(Option::is_some)).map(|(node, _)| node).collect();
    let indicator = FeatureMatrix::indicator(nodes, &held)?;
    let features = graph_features(&topology, &mesh.points, &indicator, 3)?;
    let dirichlet = Dirichlet::of_body(potential);
    let coordinates = Coordinates::Components;
    Ok((topology, Geometry { features, global: Vec::new(), dirichlet, coordinates }))
}
