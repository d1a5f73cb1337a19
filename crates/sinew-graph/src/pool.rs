//! Averages of mesh nodes at virtual nodes, through the clusters of a topology.

use crate::{
    FeatureMatrix, GraphError, Topology,
    positions::{check_positions, cluster_means},
};

/// Positions of all nodes of a geometry: a virtual node is the mean of its leaves (thesis
/// Eq. 2.16), found through the clusters of the shared topology instead of by k-means.
///
/// # Errors
/// When the positions do not belong to the topology or are not finite.
pub fn pool_positions(
    topology: &Topology,
    positions: &[[f64; 3]],
) -> Result<Vec<[f64; 3]>, GraphError> {
    topology.validate_clusters()?;
    let (expected, found) = (topology.real_nodes, positions.len());
    ensure!(
        expected == found,
        "node positions: {expected} rows needed, {found} given: use the mesh the graph was built of"
    );
    check_positions(positions)?;
    let pooled = pool(topology, positions.as_flattened(), 3);
    Ok(pooled.as_chunks().0.to_vec())
}

/// Features of all nodes: those of a virtual node are the mean over its leaves, layer by
/// layer (thesis §2.2.3).
///
/// # Errors
/// When the table does not have one row per mesh node or a number is not finite.
pub fn pool_features(
    topology: &Topology,
    real: &FeatureMatrix,
) -> Result<FeatureMatrix, GraphError> {
    topology.validate_clusters()?;
    real.check("node features", topology.real_nodes)?;
    let values = pool(topology, &real.values, real.columns);
    Ok(FeatureMatrix { rows: topology.nodes, columns: real.columns, values })
}

/// Appends the means over the clusters of every layer; the clusters must be valid.
fn pool(topology: &Topology, real: &[f64], columns: usize) -> Vec<f64> {
    let mut all = real.to_vec();
    let mut layer_start = 0;
    for (clusters, &roots) in topology.clusters.iter().zip(&topology.roots_per_layer) {
        let means = cluster_means(&all[layer_start..], columns, clusters, roots);
        layer_start = all.len();
        all.extend(means);
    }
    all
}
