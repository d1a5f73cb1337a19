//! Nested clusters of nodes.

use crate::coordinates::{CoordinateError, Result, require_count};

/// Nested clusters of nodes by recursive coordinate bisection, from two to four nodes each up to the whole body. A cluster
/// is halved across the longest side of its bounding box.
///
/// Entry `[l][i]` is the cluster of leaf `i`. Leaves of layer 0 are the nodes, leaves of layer `l` the clusters of layer
/// `l − 1`. Coordinates decide ties of distance by the index of the node, so that the same positions give the same clusters.
///
/// ```
/// let row: Vec<_> = (0..8).map(|i| [f64::from(i), 0.0, 0.0]).collect();
/// let clusters = sinew_emulate::coordinates::halves(&row);
/// assert_eq!(clusters, [vec![0, 0, 1, 1, 2, 2, 3, 3], vec![0, 0, 1, 1], vec![0, 0]]);
/// ```
pub fn halves(positions: &[[f64; 3]]) -> Vec<Vec<usize>> {
    let depth = (positions.len() / 2).max(1).ilog2();
    let mut lowest = vec![0; positions.len()];
    let mut nodes: Vec<usize> = (0..positions.len()).collect();
    halve(positions, &mut nodes, 0..1 << depth, &mut lowest);
    let above = (1..=depth).rev().map(|layer| (0..1 << layer).map(|cluster| cluster / 2).collect());
    std::iter::once(lowest).chain(above).collect()
}

/// Gives nodes the clusters of a range, half of the nodes the lower half of it.
fn halve(
    positions: &[[f64; 3]],
    nodes: &mut [usize],
    clusters: std::ops::Range<usize>,
    lowest: &mut [usize],
) {
    if clusters.len() == 1 {
        return nodes.iter().for_each(|&node| lowest[node] = clusters.start);
    }
    let extent = |axis: usize| {
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        for &node in &*nodes {
            (low, high) = (low.min(positions[node][axis]), high.max(positions[node][axis]));
        }
        high - low
    };
    let longest = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    let half = nodes.len() / 2;
    let along = |&a: &usize, &b: &usize| {
        positions[a][longest].total_cmp(&positions[b][longest]).then(a.cmp(&b))
    };
    nodes.select_nth_unstable_by(half, along);
    let middle = clusters.start + clusters.len() / 2;
    let (lower, upper) = nodes.split_at_mut(half);
    halve(positions, lower, clusters.start..middle, lowest);
    halve(positions, upper, middle..clusters.end, lowest);
}

/// Number of clusters in each layer.
pub(crate) fn counts(clusters: &[Vec<usize>], nodes: usize) -> Result<Vec<usize>> {
    let mut leaves = nodes;
    let count = |layer: &Vec<usize>| {
        require_count("leaves of clusters", layer.len(), leaves)?;
        let count = layer.iter().max().map_or(0, |last| last + 1);
        let mut used = vec![false; count.min(leaves)];
        for &cluster in layer {
            *used.get_mut(cluster).ok_or(CoordinateError::None("more clusters than leaves"))? =
                true;
        }
        if used.contains(&false) {
            return Err(CoordinateError::None("a cluster without leaves"));
        }
        leaves = count;
        Ok(count)
    };
    clusters.iter().map(count).collect()
}

/// Means of the leaves of each cluster.
pub(crate) fn centres(leaves: &[[f64; 3]], clusters: &[usize], count: usize) -> Vec<[f64; 3]> {
    let mut sums = vec![([0.0; 3], 0.0); count];
    for (leaf, &cluster) in leaves.iter().zip(clusters) {
        let (sum, size) = &mut sums[cluster];
        sum.iter_mut().zip(leaf).for_each(|(sum, x)| *sum += x);
        *size += 1.0;
    }
    sums.into_iter().map(|(sum, size)| sum.map(|sum| sum / size)).collect()
}
