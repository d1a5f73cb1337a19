//! Graph and features of a body: what every network starts from.

use crate::{Error, Geometry, Result};
use sinew_emulate::Body;
use sinew_emulate::coordinates::{Coordinates, Dirichlet, Motions};
use sinew_graph::{AugmentationConfig, FeatureMatrix, augment, graph_features};

/// Clusters per cluster of the next layer, up to the whole body (docs/design.md, "Graph").
const SHRINKAGE: usize = 2;

/// Augmented graph and features of a body (thesis Algorithm 1): the indicator of the Dirichlet boundary
/// on the nodes, difference and distance of positions on the edges. `to_one_root` continues the clusters up to the whole body, by halves
/// where `virtual_nodes` does not say how many each level has.
///
/// # Errors
/// A mesh that has no valid graph.
pub(crate) fn geometry(
    body: &Body,
    virtual_nodes: Option<&[usize]>,
    to_one_root: bool,
    seed: u64,
) -> Result<Geometry> {
    let nodes = body.nodes;
    let config = match virtual_nodes {
        Some(levels) => {
            let mut levels = levels.to_vec();
            levels.extend((to_one_root && levels.last() != Some(&1)).then_some(1));
            AugmentationConfig::of_layers(nodes, levels)
        }
        None if to_one_root => AugmentationConfig::to_one_root(nodes, SHRINKAGE),
        None => AugmentationConfig::for_nodes(nodes),
    };
    let config = AugmentationConfig { seed, ..config };
    let topology = augment(&body.positions, &body.mesh.edges(), &config).map_err(Error::Mesh)?;
    let held = body.prescribed.chunks_exact(3).enumerate();
    let held: Vec<usize> =
        held.filter(|(_, row)| row.iter().all(Option::is_some)).map(|(node, _)| node).collect();
    let indicator = FeatureMatrix::indicator(nodes, &held)?;
    let features = graph_features(&topology, &body.positions, &indicator, 3)?;
    let (dirichlet, coordinates) = (Dirichlet::of_body(body), Coordinates::Components);
    Ok(Geometry { topology, features, global: Vec::new(), dirichlet, coordinates })
}

/// Appends the Taylor coefficients of the outputs to the features of the nodes.
pub(crate) fn add_features(geometry: &mut Geometry, motions: &Motions) -> Result<()> {
    let nodes = &mut geometry.features.nodes;
    let values = motions.features();
    let columns = values.len() / nodes.rows;
    *nodes = nodes.hstack(&FeatureMatrix { rows: nodes.rows, columns, values })?;
    Ok(())
}
