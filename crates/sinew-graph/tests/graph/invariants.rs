//! The promises of the augmentation, on the thesis' beams and on random meshes.

use proptest::prelude::*;
use sinew_graph::{
    AugmentationConfig, FeatureMatrix, FeatureStatistics, Topology, augment, graph_features,
    pool_positions,
};
use sinew_mesh::{box_tetrahedra, edges};
use std::collections::HashSet;

type Positions = Vec<[f64; 3]>;

/// Written against the definitions, independently of `Topology::validate`.
fn assert_invariants(
    topology: &Topology,
    positions: &[[f64; 3]],
    mesh_edges: &[[usize; 2]],
    config: &AugmentationConfig,
) {
    let pairs: HashSet<[usize; 2]> = topology.edges().collect();
    assert_eq!(pairs.len(), topology.senders.len(), "a pair is stored twice");
    assert!(pairs.iter().all(|[sender, receiver]| receiver < sender && *sender < topology.nodes));
    let real = topology.real_nodes;
    let of_mesh: HashSet<_> = pairs.iter().copied().filter(|pair| pair[0] < real).collect();
    let given = mesh_edges.iter().map(|[a, b]| [*a.max(b), *a.min(b)]);
    assert_eq!(of_mesh, given.collect(), "the mesh's own edges");
    assert_eq!(topology.roots_per_layer, config.roots_per_layer);

    let mut reached = vec![false; topology.nodes];
    let mut front = vec![0];
    while let Some(node) = front.pop() {
        if !std::mem::replace(&mut reached[node], true) {
            let others = pairs.iter().filter(|pair| pair.contains(&node)).flatten();
            front.extend(others.filter(|other| !reached[**other]));
        }
    }
    assert!(reached.iter().all(|reached| *reached), "not connected");

    let all = pool_positions(topology, positions).unwrap();
    let layers = topology.roots_per_layer.len();
    for layer in 0..layers {
        let (leaves, roots) = (topology.layer(layer), topology.layer(layer + 1));
        for leaf in leaves.clone() {
            let above: Vec<_> = pairs
                .iter()
                .filter(|[sender, receiver]| *receiver == leaf && *sender >= leaves.end)
                .collect();
            let root = roots.start + topology.clusters[layer][leaf - leaves.start];
            assert_eq!(above, [&[root, leaf]], "exactly one root");
        }
        for root in roots.clone() {
            let inside = |other: &usize| roots.contains(other) && *other != root;
            let joined =
                pairs.iter().filter(|pair| pair.contains(&root)).flatten().filter(|n| inside(n));
            let degree = joined.count();
            if layer + 1 == layers {
                assert_eq!(degree, roots.len() - 1, "the last layer is fully connected");
            } else {
                assert!(degree >= config.neighbours, "{degree} neighbours of root {root}");
            }
            let below: Vec<_> = leaves
                .clone()
                .filter(|leaf| topology.clusters[layer][leaf - leaves.start] == root - roots.start)
                .collect();
            assert!(!below.is_empty(), "an empty cluster");
            for axis in 0..3 {
                let sum: f64 = below.iter().map(|&leaf| all[leaf][axis]).sum();
                let error = all[root][axis] - sum / below.len() as f64;
                // Roundings of a mean of up to a few hundred coordinates of order 100.
                assert!(error.abs() < 1e-10, "root {root} is off the mean by {error:e}");
            }
        }
    }
    topology.validate().unwrap();
}

fn beams() -> [(Positions, Vec<[usize; 2]>); 2] {
    [[100.0, 10.0, 10.0], [150.0, 10.0, 2.0]].map(|extent| {
        let mesh = box_tetrahedra(extent, [12, 4, 5]);
        let edges = edges(&mesh);
        (mesh.points, edges)
    })
}

#[test]
fn the_beams_of_chapter_3() {
    for (positions, mesh_edges) in beams() {
        let config = AugmentationConfig::for_nodes(positions.len());
        let topology = augment(&positions, &mesh_edges, &config).unwrap();
        assert_eq!(topology.nodes, 390 + 97 + 24);
        assert_invariants(&topology, &positions, &mesh_edges, &config);
    }
}

#[test]
fn threads_do_not_change_the_topology() {
    let [(positions, mesh_edges), _] = beams();
    let config = AugmentationConfig::for_nodes(positions.len());
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| augment(&positions, &mesh_edges, &config).unwrap())
    };
    let one = on(1);
    for threads in [2, 3, 7] {
        assert_eq!(on(threads), one);
    }
}

#[test]
fn seeds_decide() {
    let [(positions, mesh_edges), _] = beams();
    let with = |seed| {
        let config = AugmentationConfig { seed, ..AugmentationConfig::for_nodes(390) };
        augment(&positions, &mesh_edges, &config).unwrap()
    };
    assert_eq!(with(1), with(1));
    assert_ne!(with(1).clusters, with(2).clusters);
}

#[test]
fn clusters_are_near_the_best_known() {
    // Layer 1 of the beam: 100 runs of linfa's own k-means reach 3.35 mm² per node. Ten runs of
    // ours stay below 3.52 mm² for each of 100 seeds, a single one averages 3.56.
    let [(positions, mesh_edges), _] = beams();
    let config = AugmentationConfig::for_nodes(390);
    let topology = augment(&positions, &mesh_edges, &config).unwrap();
    let inertia = crate::inertia(&topology, &positions);
    assert!(inertia < 3.52, "{inertia}");
}

#[test]
fn geometries_share_a_topology() {
    let [(long, mesh_edges), (thin, same_edges)] = beams();
    assert_eq!(mesh_edges, same_edges);
    let half = |(x, y): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|axis| 0.5 * (x[axis] + y[axis]));
    let mean: Vec<_> = long.iter().zip(&thin).map(half).collect();
    let config = AugmentationConfig::for_nodes(390);
    let topology = augment(&mean, &mesh_edges, &config).unwrap();
    let clamped: Vec<usize> = (0..390).filter(|&node| long[node][0] == 0.0).collect();
    let columns = FeatureMatrix::indicator(390, &clamped).unwrap();
    let features = [&long, &thin].map(|x| graph_features(&topology, x, &columns, 3).unwrap());
    let statistics = FeatureStatistics::over(&features).unwrap();
    let standardised = features.map(|f| statistics.standardise(&f).unwrap());
    for column in 0..4 {
        let values =
            || standardised.iter().flat_map(|f| f.edges.values.iter().skip(column).step_by(4));
        let count = values().count() as f64;
        let mean = values().sum::<f64>() / count;
        let variance = values().map(|v| v * v).sum::<f64>() / count;
        assert!(mean.abs() < 1e-12 && (variance - 1.0).abs() < 1e-12, "{mean} {variance}");
    }
}

prop_compose! {
    /// Random nodes, some of them coincident or on a coarse grid, random edges and layers.
    fn random_mesh()(
        nodes in 2usize..60,
        snapped in any::<bool>(),
    )(
        positions in prop::collection::vec(prop::array::uniform3(-50.0..50.0f64), nodes),
        mesh_edges in prop::collection::vec((0..nodes, 1..nodes), 0..3 * nodes),
        first in 1..nodes,
        second in 1usize..60,
        neighbours in 0usize..6,
        seed in any::<u64>(),
        snapped in Just(snapped),
        nodes in Just(nodes),
    ) -> (Positions, Vec<[usize; 2]>, AugmentationConfig) {
        let snap = |x: f64| if snapped { 25.0 * (x / 25.0).round() } else { x };
        let positions = positions.iter().map(|x| x.map(snap)).collect();
        let mesh_edges = mesh_edges.iter().map(|&(a, step)| [a, (a + step) % nodes]).collect();
        let mut roots_per_layer = vec![first];
        if second < first && neighbours < first {
            roots_per_layer.push(second);
        }
        (positions, mesh_edges, AugmentationConfig { roots_per_layer, neighbours, seed, runs: 2 })
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn random_meshes((positions, mesh_edges, config) in random_mesh()) {
        let topology = augment(&positions, &mesh_edges, &config).unwrap();
        assert_invariants(&topology, &positions, &mesh_edges, &config);
        prop_assert_eq!(&augment(&positions, &mesh_edges, &config).unwrap(), &topology);
    }

    #[test]
    fn translations_change_no_feature(
        (positions, mesh_edges, config) in random_mesh(),
        translation in prop::array::uniform3(-1e3..1e3f64),
    ) {
        let topology = augment(&positions, &mesh_edges, &config).unwrap();
        let columns = FeatureMatrix::indicator(positions.len(), &[0]).unwrap();
        let moved: Positions = positions
            .iter()
            .map(|x| std::array::from_fn(|axis| x[axis] + translation[axis]))
            .collect();
        let here = graph_features(&topology, &positions, &columns, 3).unwrap();
        let there = graph_features(&topology, &moved, &columns, 3).unwrap();
        prop_assert_eq!(&here.nodes, &there.nodes);
        // Rounding of coordinates of 1e3, a few times over: 1e3 × 2⁻⁵² × 20.
        let tolerance = 1e3 * f64::EPSILON * 20.0;
        for (a, b) in here.edges.values.iter().zip(&there.edges.values) {
            prop_assert!((a - b).abs() < tolerance, "{} moved by {:e}", a, a - b);
        }
    }
}
