//! k-means clustering of positions.
//!
//! Lloyd's iterations are linfa's. The k-means++ starts are drawn here, because linfa's own
//! compares every point with every earlier centre again for each new one: with a quarter as many
//! centres as points, as in thesis Algorithm 1, 4096 points then take 4.5 s per run instead of
//! 0.2 s. linfa's parallel loops treat points one by one, so the result does not depend on the
//! number of threads.

use crate::{
    GraphError,
    positions::{cluster_means, range},
};
use linfa::DatasetBase;
use linfa::traits::{Fit, Predict};
use linfa_clustering::{KMeans, KMeansInit};
use ndarray::Array2;
use rand::{Rng, RngExt};
use std::ops::Range;

/// Movement of the centres, as the root of the sum of squares in units of the largest extent of
/// the body, that ends the iteration. A hundredth of it changes no cluster of 1570 random points.
const TOLERANCE: f64 = 1e-3;
/// Bound on Lloyd's iterations.
const ITERATIONS: u64 = 100;

/// Most distances of an iteration, about 0.02 s. Its time grows with the square of the body, so that the leaves are halved first beyond.
const MOST_DISTANCES: usize = 1 << 23;

/// Groups `leaves` into exactly `roots` clusters, none empty: the root of each leaf, roots
/// numbered by their first leaf. The best of `runs` starts by inertia. Leaves beyond [`MOST_DISTANCES`] are
/// clustered in halves across their longest extent.
///
/// k-means may leave a cluster empty, and does when positions coincide. Then the leaf farthest
/// from its cluster's mean, the first of equals, becomes that cluster, until none is empty.
///
/// Needs at least one run, `1 ≤ roots ≤ leaves.len()` and finite positions of order one.
pub(crate) fn cluster(
    leaves: &[[f64; 3]],
    roots: usize,
    runs: usize,
    random: &mut impl Rng,
) -> Result<Vec<usize>, GraphError> {
    let mut clusters = vec![0; leaves.len()];
    let mut blocks = vec![((0..leaves.len()).collect::<Vec<_>>(), 0..roots)];
    while let Some((block, range)) = blocks.pop() {
        if range.len() > 1 && block.len() * range.len() > MOST_DISTANCES {
            blocks.extend(halves(leaves, block, range));
            continue;
        }
        let places: Vec<_> = block.iter().map(|&leaf| leaves[leaf]).collect();
        let found = cluster_at_once(&places, range.len(), runs, random)?;
        block.iter().zip(found).for_each(|(&leaf, root)| clusters[leaf] = range.start + root);
    }
    Ok(numbered_by_first_leaf(roots, clusters))
}

/// Halves of a block of leaves across its longest extent, with their shares of the roots.
fn halves(
    leaves: &[[f64; 3]],
    mut block: Vec<usize>,
    roots: Range<usize>,
) -> [(Vec<usize>, Range<usize>); 2] {
    let places: Vec<_> = block.iter().map(|&leaf| leaves[leaf]).collect();
    let extent = |axis: &usize| {
        let [lowest, highest] = range(&places, *axis);
        highest - lowest
    };
    let longest = (0..3).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    block.sort_by(|&a, &b| leaves[a][longest].total_cmp(&leaves[b][longest]));
    let second = block.split_off(block.len() / 2);
    let middle = roots.start + roots.len() / 2;
    [(block, roots.start..middle), (second, middle..roots.end)]
}

fn cluster_at_once(
    leaves: &[[f64; 3]],
    roots: usize,
    runs: usize,
    random: &mut impl Rng,
) -> Result<Vec<usize>, GraphError> {
    let count = leaves.len();
    let records = Array2::from(leaves.to_vec());
    let dataset = DatasetBase::from(records.view());
    let mut best = (f64::INFINITY, Vec::new());
    for _ in 0..runs {
        let start = Array2::from(plus_plus_start(leaves, roots, random));
        let model = KMeans::params(roots)
            .init_method(KMeansInit::Precomputed(start))
            .n_runs(1)
            .tolerance(TOLERANCE)
            .max_n_iterations(ITERATIONS)
            .fit(&dataset)
            .map_err(|error| {
                GraphError(format!("k-means of {count} leaves into {roots} roots failed: {error}"))
            })?;
        let mut clusters = model.predict(&records).to_vec();
        fill_empty_clusters(leaves, roots, &mut clusters);
        let inertia = squared_distances(leaves, roots, &clusters).iter().sum();
        if inertia < best.0 {
            best = (inertia, clusters);
        }
    }
    Ok(best.1)
}

/// k-means++ (Arthur & Vassilvitskii, "k-means++: the advantages of careful seeding", 2007):
/// each next centre is a leaf drawn with probability proportional to its squared distance from
/// the nearest centre so far.
fn plus_plus_start(leaves: &[[f64; 3]], roots: usize, random: &mut impl Rng) -> Vec<[f64; 3]> {
    let mut centres = vec![leaves[random.random_range(0..leaves.len())]];
    let mut distances = vec![f64::INFINITY; leaves.len()];
    while centres.len() < roots {
        let last = centres[centres.len() - 1];
        for (distance, leaf) in distances.iter_mut().zip(leaves) {
            *distance = distance.min(squared_distance(leaf, &last));
        }
        let mut rest = random.random::<f64>() * distances.iter().sum::<f64>();
        let mut chosen = 0;
        for (leaf, &distance) in distances.iter().enumerate().filter(|(_, d)| **d > 0.0) {
            chosen = leaf;
            rest -= distance;
            if rest < 0.0 {
                break;
            }
        }
        centres.push(leaves[chosen]);
    }
    centres
}

fn fill_empty_clusters(leaves: &[[f64; 3]], roots: usize, clusters: &mut [usize]) {
    let mut sizes = vec![0usize; roots];
    clusters.iter().for_each(|&root| sizes[root] += 1);
    for empty in 0..roots {
        if sizes[empty] > 0 {
            continue;
        }
        let distances = squared_distances(leaves, roots, clusters);
        let several = (0..leaves.len()).rev().filter(|&leaf| sizes[clusters[leaf]] > 1);
        // The last of equals in this order is the first.
        let farthest = several.max_by(|&a, &b| distances[a].total_cmp(&distances[b])).unwrap_or(0);
        sizes[clusters[farthest]] -= 1;
        sizes[empty] += 1;
        clusters[farthest] = empty;
    }
}

/// Squared distance of each leaf from the mean of its cluster.
fn squared_distances(leaves: &[[f64; 3]], roots: usize, clusters: &[usize]) -> Vec<f64> {
    let means = cluster_means(leaves.as_flattened(), 3, clusters, roots);
    let means = means.as_chunks().0;
    leaves.iter().zip(clusters).map(|(leaf, &root)| squared_distance(leaf, &means[root])).collect()
}

fn squared_distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum()
}

fn numbered_by_first_leaf(roots: usize, mut clusters: Vec<usize>) -> Vec<usize> {
    let mut number = vec![None; roots];
    let mut next = 0;
    for root in &mut clusters {
        *root = *number[*root].get_or_insert_with(|| {
            next += 1;
            next - 1
        });
    }
    clusters
}
