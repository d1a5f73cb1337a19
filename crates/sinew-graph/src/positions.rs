//! Positions: their extent, and means over clusters.

use crate::error::GraphError;

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
