//! Edges within a layer, against the definition without a search tree.

use sinew_graph::{AugmentationConfig, augment};

/// Pairs of places of which one is among the nearest of the other; the lower index is nearer among equals.
fn by_comparison(places: &[[f64; 3]], neighbours: usize) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    for (i, a) in places.iter().enumerate() {
        let distance = |j: usize| (0..3).map(|d| (a[d] - places[j][d]).powi(2)).sum::<f64>();
        let mut others: Vec<usize> = (0..places.len()).filter(|&j| j != i).collect();
        others.sort_by(|&j, &k| distance(j).total_cmp(&distance(k)).then(j.cmp(&k)));
        pairs.extend(others.into_iter().take(neighbours).map(|j| [i.max(j), i.min(j)]));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Pairs of the first layer of a graph with two nodes at each of some places. Their clusters are the places, which a last
/// layer of one root joins.
fn within_layer(places: &[[f64; 3]], neighbours: usize) -> Vec<[usize; 2]> {
    let config =
        AugmentationConfig { roots_per_layer: vec![places.len(), 1], neighbours, seed: 3, runs: 1 };
    let topology = augment(&[places, places].concat(), &[], &config).unwrap();
    let roots = topology.layer(1);
    let inside =
        |[sender, receiver]: &[usize; 2]| roots.contains(sender) && roots.contains(receiver);
    topology.edges().filter(inside).map(|edge| edge.map(|node| node - roots.start)).collect()
}

#[test]
fn regular_grids_of_many_equal_coordinates() {
    // 561 points in a plane, 33 per line, and 129 in one line: more equal coordinates than a bucket of 32 holds.
    // Extents are powers of two, so that equal distances stay equal in the unit box.
    let plane: Vec<_> = (0..33 * 17).map(|i| [(i % 33) as f64, (i / 33) as f64, 0.0]).collect();
    assert_eq!(within_layer(&plane, 5), by_comparison(&plane, 5));
    let line: Vec<_> = (0..129).map(|i| [0.0, 0.5, i as f64]).collect();
    assert_eq!(within_layer(&line, 4), by_comparison(&line, 4));
}

#[test]
fn coincident_points() {
    let same = [[0.25, 0.5, 0.75]; 100];
    assert_eq!(within_layer(&same, 3), by_comparison(&same, 3));
}

#[test]
fn zero_neighbours_and_more_than_there_are() {
    let points = [[0.0; 3], [1.0; 3], [3.0; 3]];
    assert!(within_layer(&points, 0).is_empty());
    assert_eq!(within_layer(&points, 9), [[1, 0], [2, 0], [2, 1]]);
}
