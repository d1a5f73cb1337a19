//! Rigid motions of nested clusters, by which outputs of networks become displacements.

use super::comparison::{device, numbers, random};
use burn::tensor::{DType, Tensor};
use sinew_emulate::coordinates::MotionTree;

const NODES: usize = 5;
const CLUSTERS: usize = 4;
/// Rounding of double precision through three rotations, also by small angles.
const ROUNDING: f64 = 1e-10;

/// Five nodes in two clusters, these in one, and that beside a lonely root; scales that mix all outputs.
fn tree() -> MotionTree {
    let wave = |seed: usize| 7.0 * (seed as f64 * 1.7).sin();
    let point = |seed: usize| std::array::from_fn(|i| wave(3 * seed + i));
    MotionTree {
        node_parents: vec![0, 0, 1, 1, 3],
        cluster_parents: vec![Some(2), Some(2), None, None],
        positions: (0..NODES).map(point).collect(),
        centres: (10..10 + CLUSTERS).map(point).collect(),
        node_scales: (0..NODES).map(|n| mixing(n as f64)).collect(),
        cluster_scales: (0..CLUSTERS).map(|c| mixing(10.0 + c as f64)).collect(),
    }
}

fn mixing<const N: usize>(seed: f64) -> [[f64; N]; N] {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let own = if i == j { 0.8 } else { 0.0 };
            own + 0.2 * (seed + (3 * i + j) as f64).sin()
        })
    })
}

/// Composition written down as it is: every node moved by its clusters one after the other.
fn composed(clusters: &Tensor<2>, nodes: &Tensor<2>, tree: &MotionTree) -> Tensor<2> {
    let column = |x: &Tensor<2>, j: usize| x.clone().slice_dim(1, j..j + 1);
    let combine = |x: &Tensor<2>, first: usize, row: &[f64]| -> Tensor<2> {
        let terms = row.iter().enumerate().map(|(j, s)| column(x, first + j) * *s);
        terms.reduce(|a, b| a + b).unwrap()
    };
    let mut displacement = Vec::new();
    for node in 0..NODES {
        let at = tree.positions[node];
        let mut x: Vec<Tensor<2>> =
            (0..3).map(|i| combine(nodes, 3 * node, &tree.node_scales[node][i]) + at[i]).collect();
        let mut cluster = Some(tree.node_parents[node]);
        while let Some(k) = cluster {
            let motion: Vec<Tensor<2>> =
                (0..6).map(|i| combine(clusters, 6 * k, &tree.cluster_scales[k][i])).collect();
            let centre = tree.centres[k];
            let arm: Vec<Tensor<2>> = (0..3).map(|i| x[i].clone() - centre[i]).collect();
            let w = &motion[3..];
            let square = w.iter().map(|w| w.clone() * w.clone()).reduce(|a, b| a + b).unwrap();
            let angle = square.clone().sqrt();
            // Rodrigues: r cos φ + (e × r) sin φ + e (e · r) (1 − cos φ).
            let along = (0..3).map(|i| w[i].clone() * arm[i].clone()).reduce(|a, b| a + b).unwrap();
            x = (0..3)
                .map(|i| {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    let cross = w[j].clone() * arm[k].clone() - w[k].clone() * arm[j].clone();
                    arm[i].clone() * angle.clone().cos()
                        + cross * angle.clone().sin() / angle.clone()
                        + w[i].clone() * along.clone() * (1.0 - angle.clone().cos())
                            / square.clone()
                        + motion[i].clone()
                        + centre[i]
                })
                .collect();
            cluster = tree.cluster_parents[k];
        }
        displacement.extend((0..3).map(|i| x[i].clone() - at[i]));
    }
    Tensor::cat(displacement, 1)
}

fn assert_equal(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < ROUNDING * largest, "{found} for {expected}");
    }
}

/// Displacements of outputs of clusters, where nodes add none.
fn moved(tree: &MotionTree, clusters: [f64; 6 * CLUSTERS]) -> Vec<f64> {
    tree.moved(&[&clusters[..], &[0.0; 3 * NODES]].concat())
}

#[test]
fn it_is_the_composition_of_rigid_motions() {
    let (device, tree) = (device(), tree());
    for (seed, size) in [(1, 1.0), (2, 1.0), (1, 0.1)] {
        let leaf = |columns: usize, seed: u64, size: f64| {
            let x = random([1, columns], seed, &device).cast(DType::F64) * size;
            x.detach().require_grad()
        };
        let (clusters, nodes) = (leaf(6 * CLUSTERS, seed, size), leaf(3 * NODES, seed + 5, 1.0));
        let displacement = composed(&clusters, &nodes, &tree);
        let outputs = [numbers(&clusters), numbers(&nodes)].concat();
        assert_equal(&tree.moved(&outputs), &numbers(&displacement));

        let cotangent = random([1, 3 * NODES], seed + 9, &device).cast(DType::F64);
        let gradients = (displacement * cotangent.clone()).sum().backward();
        let gradient = |x: &Tensor<2>| numbers(&x.grad(&gradients).unwrap());
        let expected = [gradient(&clusters), gradient(&nodes)].concat();
        assert_equal(&tree.pull_back(&outputs, &numbers(&cotangent)), &expected);
    }
}

#[test]
fn one_rigid_motion_of_the_whole_body_strains_nothing() {
    // A turn by 170 degrees and a long way.
    let mut whole = tree();
    whole.cluster_parents = vec![Some(2), Some(2), Some(3), None];
    whole.cluster_scales[3] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let mut clusters = [0.0; 6 * CLUSTERS];
    let turn = 170f64.to_radians();
    clusters[18..].copy_from_slice(&[30.0, -20.0, 10.0, 0.48 * turn, -0.6 * turn, 0.64 * turn]);
    let u = moved(&whole, clusters);
    let place = |n: usize, moved: f64| -> [f64; 3] {
        std::array::from_fn(|i| whole.positions[n][i] + moved * u[3 * n + i])
    };
    let distance =
        |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    for (a, b) in (0..NODES).flat_map(|a| (0..a).map(move |b| (a, b))) {
        let (rest, moved) =
            (distance(place(a, 0.0), place(b, 0.0)), distance(place(a, 1.0), place(b, 1.0)));
        assert!((moved - rest).abs() < 1e-12 * rest, "{rest} became {moved}");
    }
}

#[test]
fn small_displacements_of_a_far_body_keep_their_digits() {
    // Turned by 1e-6 rad a kilometre away from the origin of coordinates.
    let mut tree = tree();
    let far = |x: &mut [f64; 3]| x[0] += 1e6;
    tree.positions.iter_mut().for_each(far);
    tree.centres.iter_mut().for_each(far);
    tree.cluster_scales[2] = [[0.0; 6]; 6];
    tree.cluster_scales[2][5][5] = 1e-6;
    let mut clusters = [0.0; 6 * CLUSTERS];
    clusters[17] = 1.0;
    let u = moved(&tree, clusters);
    for node in 0..4 {
        let [x, y, _]: [f64; 3] =
            std::array::from_fn(|i| tree.positions[node][i] - tree.centres[2][i]);
        assert!((u[3 * node] + 1e-6 * y).abs() < 1e-11, "{}", u[3 * node]);
        assert!((u[3 * node + 1] - 1e-6 * x).abs() < 1e-11);
    }
}
