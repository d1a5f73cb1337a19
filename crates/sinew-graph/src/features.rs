//! Numbers on nodes and edges.

use crate::{FeatureMatrix, GraphError, Topology, pool_features, pool_positions, positions::range};
use serde::{Deserialize, Serialize};

/// The features of one geometry on a [`Topology`], raw or standardised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraphFeatures {
    /// One row per node, virtual ones included.
    pub nodes: FeatureMatrix,
    /// One row per stored edge, in the order of [`Topology::senders`].
    pub edges: FeatureMatrix,
}

/// Features of one geometry: the caller's columns pooled to the virtual nodes, and
/// `(x_j − x_i, ‖x_j − x_i‖)` on the edge from sender `i` to receiver `j` (thesis Eq. 2.23).
///
/// * `positions` — mesh node positions [length unit of the scene].
/// * `node_columns` — any numbers per mesh node but no absolute positions, which would end
///   the emulator's invariance to translations.
/// * `dimensions` — coordinates that enter: 2 for a plane mesh, 3 in space.
///
/// # Errors
/// When a table does not belong to the topology, a number is not finite, or a coordinate left
/// out is not constant.
pub fn graph_features(
    topology: &Topology,
    positions: &[[f64; 3]],
    node_columns: &FeatureMatrix,
    dimensions: usize,
) -> Result<GraphFeatures, GraphError> {
    let nodes = pool_features(topology, node_columns)?;
    let positions = pool_positions(topology, positions)?;
    check_dimensions(&positions[..topology.real_nodes], dimensions)?;
    let (rows, columns) = (topology.senders.len(), dimensions + 1);
    let mut values = Vec::with_capacity(rows * columns);
    for [sender, receiver] in topology.edges() {
        let (from, to) = (positions[sender], positions[receiver]);
        let step: [f64; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
        values.extend_from_slice(&step[..dimensions]);
        values.push(step[..dimensions].iter().fold(0.0, |length: f64, s| length.hypot(*s)));
    }
    let edges = FeatureMatrix { rows, columns, values };
    edges.check("edge features", rows)?;
    Ok(GraphFeatures { nodes, edges })
}

/// The first `dimensions` coordinates must tell the whole shape.
fn check_dimensions(positions: &[[f64; 3]], dimensions: usize) -> Result<(), GraphError> {
    ensure!(
        (1..=3).contains(&dimensions),
        "{dimensions} space dimensions were asked for: use 1, 2 or 3"
    );
    for axis in dimensions..3 {
        let [lowest, highest] = range(positions, axis);
        ensure!(
            lowest == highest,
            "coordinate {axis} runs from {lowest} to {highest}, but only {dimensions} dimensions enter the edge features: use {}",
            axis + 1
        );
    }
    Ok(())
}
