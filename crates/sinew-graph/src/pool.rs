//! From mesh nodes to virtual nodes, through the clusters of a topology.

use crate::{FeatureMatrix, GraphError, Topology, augment::check_positions};

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
    if expected != found {
        return Err(GraphError::RowCount { what: "node positions", expected, found });
    }
    check_positions(positions)?;
    let pooled = pool(topology, positions.as_flattened(), 3);
    Ok(pooled.chunks_exact(3).map(|x| [x[0], x[1], x[2]]).collect())
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

/// The node-wise mean of several geometries with one connectivity: the representative graph
/// to [`crate::augment`] (thesis §2.2.3).
///
/// # Errors
/// When there is no geometry, or they differ in their number of nodes.
pub fn mean_geometry(geometries: &[Vec<[f64; 3]>]) -> Result<Vec<[f64; 3]>, GraphError> {
    let first = geometries.first().ok_or(GraphError::NoGeometry)?;
    let mut mean = vec![[0.0; 3]; first.len()];
    let share = 1.0 / geometries.len() as f64;
    for geometry in geometries {
        if geometry.len() != first.len() {
            let (what, expected, found) = ("node positions", first.len(), geometry.len());
            return Err(GraphError::RowCount { what, expected, found });
        }
        check_positions(geometry)?;
        for (mean, x) in mean.iter_mut().zip(geometry) {
            *mean = std::array::from_fn(|axis| mean[axis] + share * x[axis]);
        }
    }
    Ok(mean)
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

/// Means over clusters, summed relative to each cluster's first leaf: a constant stays exactly
/// constant, and positions far from the origin lose no digits.
pub(crate) fn cluster_means(
    leaves: &[f64],
    columns: usize,
    clusters: &[usize],
    roots: usize,
) -> Vec<f64> {
    let mut first = vec![None; roots];
    let mut sizes = vec![0usize; roots];
    let mut sums = vec![0.0; roots * columns];
    for (leaf, &root) in clusters.iter().enumerate() {
        let origin = *first[root].get_or_insert(leaf);
        sizes[root] += 1;
        for c in 0..columns {
            sums[root * columns + c] += leaves[leaf * columns + c] - leaves[origin * columns + c];
        }
    }
    for (root, (&size, first)) in sizes.iter().zip(first).enumerate() {
        let origin = first.unwrap_or(0);
        for c in 0..columns {
            let sum = &mut sums[root * columns + c];
            *sum = leaves[origin * columns + c] + *sum / size as f64;
        }
    }
    sums
}
