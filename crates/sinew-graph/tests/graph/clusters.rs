//! Clusters by k-means.

use sinew_graph::{AugmentationConfig, Topology, augment};

/// The graph of nodes without edges, whose clusters a last layer of one root joins.
fn clustered(nodes: &[[f64; 3]], roots: usize, runs: usize, seed: u64) -> Topology {
    let config = AugmentationConfig { roots_per_layer: vec![roots, 1], neighbours: 1, seed, runs };
    augment(nodes, &[], &config).unwrap()
}

#[test]
fn separate_heaps_are_found() {
    let heap = |x: f64| (0..5).map(move |i| [x + 0.01 * i as f64, 0.0, 0.02 * i as f64]);
    let nodes: Vec<_> = heap(0.5).chain(heap(0.0)).chain(heap(1.0)).collect();
    let clusters = &clustered(&nodes, 3, 10, 1).clusters[0];
    assert_eq!(*clusters, [0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2]);
}

#[test]
fn large_bodies_are_clustered_in_halves() {
    let side = 20;
    let at = |i: usize| [i % side, i / side % side, i / (side * side)].map(|x| x as f64 / 10.0);
    let nodes: Vec<_> = (0..side * side * 12).map(at).collect();
    let roots = nodes.len() / 2 - 1;
    assert!(nodes.len() * roots > 1 << 23, "few enough distances for one block");
    let topology = clustered(&nodes, roots, 1, 1);
    let all = sinew_graph::pool_positions(&topology, &nodes).unwrap();
    let mut sizes = vec![0; roots];
    for (node, &root) in topology.clusters[0].iter().enumerate() {
        sizes[root] += 1;
        // Leaves of a cluster are neighbours.
        let centre = all[topology.layer(1).start + root];
        let distance: f64 = (0..3).map(|axis| (nodes[node][axis] - centre[axis]).powi(2)).sum();
        assert!(distance < 0.2f64.powi(2), "node {node}: {distance}");
    }
    assert!(sizes.iter().all(|&size| size > 0));
}

#[test]
fn a_cluster_that_no_place_is_left_for_takes_a_coincident_node() {
    // Three clusters at two places: one is empty until the first node that is not alone becomes it.
    let (a, b) = ([0.0; 3], [1.0, 0.0, 0.0]);
    assert_eq!(clustered(&[a, a, a, b], 3, 1, 3).clusters[0], [0, 1, 1, 2]);
}

#[test]
fn starts_are_distinct_where_positions_are() {
    // As many clusters as places: nothing but the two nodes that coincide shares one.
    let mut nodes: Vec<_> = (0..20).map(|i| [i as f64 / 19.0, 0.0, 0.0]).collect();
    nodes.push(nodes[7]);
    let topology = clustered(&nodes, 20, 1, 3);
    let expected: Vec<usize> = (0..20).chain([7]).collect();
    assert_eq!(topology.clusters[0], expected);
    assert_eq!(crate::inertia(&topology, &nodes), 0.0);
}
