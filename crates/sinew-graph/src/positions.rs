//! Positions: their extent, and means over clusters; averages of mesh nodes at virtual nodes.

use crate::error::GraphError;
use crate::{FeatureMatrix, Topology};

/// Lowest corner and longest side of the bounding box.
pub(crate) type Extent = ([f64; 3], f64);

/// Requires finite coordinates and finite differences; returns the extent.
pub(crate) fn check_positions(positions: &[[f64; 3]]) -> Result<Extent, GraphError> {
    let (mut corner, mut longest) = ([0.0; 3], 0.0f64);
    for axis in 0..3 {
        for (node, value) in positions.iter().map(|x| x[axis]).enumerate() {
            ensure!(
                value.is_finite(),
                "coordinate {axis} of node {node} is {value}: repair the mesh, or leave the node out if no cell uses it"
            );
        }
        let [lowest, highest] = range(positions, axis);
        ensure!(
            highest - lowest < f64::INFINITY,
            "coordinate {axis} runs from {lowest:e} to {highest:e}, a distance beyond double precision: choose a larger unit of length"
        );
        corner[axis] = lowest;
        longest = longest.max(highest - lowest);
    }
    Ok((corner, longest))
}

/// Smallest and largest of one coordinate.
pub(crate) fn range(positions: &[[f64; 3]], axis: usize) -> [f64; 2] {
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    positions.iter().fold(ends, |[low, high], x| [low.min(x[axis]), high.max(x[axis])])
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
