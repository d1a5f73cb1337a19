use super::{FieldMap, mapped};
use crate::fused::tests::{Comparison, device, random};
use burn::tensor::{DType, Tensor};
use sinew_emulate::coordinates::MotionTree;
use std::sync::Arc;

const NODES: usize = 5;
const CLUSTERS: usize = 4;

impl FieldMap for MotionTree {
    fn displacement(&self, _: usize, outputs: &[f64]) -> Vec<f64> {
        self.moved(outputs)
    }

    fn pull_back(&self, _: usize, outputs: &[f64], cotangent: &[f64]) -> Vec<f64> {
        self.pull_back(outputs, cotangent)
    }
}

fn rigid_motions(clusters: Tensor<3>, nodes: Tensor<3>, tree: &Arc<MotionTree>) -> Tensor<3> {
    mapped(Some(clusters), nodes, tree.clone())
}

/// Five nodes in two clusters, these in one, and that beside a lonely root; scales that mix all outputs.
fn tree() -> Arc<MotionTree> {
    let wave = |seed: usize| 7.0 * (seed as f64 * 1.7).sin();
    let point = |seed: usize| std::array::from_fn(|i| wave(3 * seed + i));
    Arc::new(MotionTree {
        node_parents: vec![0, 0, 1, 1, 3],
        cluster_parents: vec![Some(2), Some(2), None, None],
        positions: (0..NODES).map(point).collect(),
        centres: (10..10 + CLUSTERS).map(point).collect(),
        node_scales: (0..NODES).map(|n| mixing(n as f64)).collect(),
        cluster_scales: (0..CLUSTERS).map(|c| mixing(10.0 + c as f64)).collect(),
    })
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

#[test]
fn it_is_the_composition_of_rigid_motions() {
    let (device, tree) = (device(), tree());
    for samples in [1, 3] {
        for size in [1.0, 0.1] {
            let clusters = random([samples, 6 * CLUSTERS], 1, &device) * size;
            let nodes = random([samples, 3 * NODES], 2, &device);
            Comparison::of([clusters, nodes]).assert_close(
                |x| {
                    let clusters = x[0].clone().reshape([samples, CLUSTERS, 6]);
                    let nodes = x[1].clone().reshape([samples, NODES, 3]);
                    rigid_motions(clusters, nodes, &tree).reshape([samples, 3 * NODES])
                },
                |x| composed(&x[0], &x[1], &tree),
            );
        }
    }
}

#[test]
fn one_rigid_motion_of_the_whole_body_strains_nothing() {
    // A turn by 170 degrees and a long way; distances stay what they were to the rounding of single precision.
    let (device, tree) = (device(), tree());
    let mut whole = (*tree).clone();
    whole.cluster_parents = vec![Some(2), Some(2), Some(3), None];
    whole.cluster_scales[3] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let mut clusters = [0.0f32; 6 * CLUSTERS];
    let turn = 170f64.to_radians();
    let motion = [30.0, -20.0, 10.0, 0.48 * turn, -0.6 * turn, 0.64 * turn];
    clusters[18..].iter_mut().zip(motion).for_each(|(c, m)| *c = m as f32);
    let clusters = Tensor::<1>::from_floats(&clusters[..], &device).reshape([1, CLUSTERS, 6]);
    let nodes = Tensor::zeros([1, NODES, 3], &device);
    let u = rigid_motions(clusters, nodes, &Arc::new(whole.clone()));
    let u: Vec<f64> = u.cast(DType::F64).into_data().iter::<f64>().collect();
    let place = |n: usize, moved: f64| -> [f64; 3] {
        std::array::from_fn(|i| whole.positions[n][i] + moved * u[3 * n + i])
    };
    let distance =
        |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    for (a, b) in (0..NODES).flat_map(|a| (0..a).map(move |b| (a, b))) {
        let (rest, moved) =
            (distance(place(a, 0.0), place(b, 0.0)), distance(place(a, 1.0), place(b, 1.0)));
        assert!((moved - rest).abs() < 1e-5, "{rest} became {moved}");
    }
}

#[test]
fn small_displacements_of_a_far_body_keep_their_digits() {
    // Turned by 1e-6 rad a kilometre away from the origin of coordinates.
    let (device, mut tree) = (device(), (*tree()).clone());
    let far = |x: &mut [f64; 3]| x[0] += 1e6;
    tree.positions.iter_mut().for_each(far);
    tree.centres.iter_mut().for_each(far);
    tree.cluster_scales[2] = mixing::<6>(0.0).map(|_| [0.0; 6]);
    tree.cluster_scales[2][5][5] = 1e-6;
    let mut clusters = [0.0f32; 6 * CLUSTERS];
    clusters[17] = 1.0;
    let clusters = Tensor::<1>::from_floats(&clusters[..], &device).reshape([1, CLUSTERS, 6]);
    let u = rigid_motions(clusters, Tensor::zeros([1, NODES, 3], &device), &Arc::new(tree.clone()));
    let u: Vec<f64> = u.into_data().iter::<f64>().collect();
    for node in 0..4 {
        let [x, y, _]: [f64; 3] =
            std::array::from_fn(|i| tree.positions[node][i] - tree.centres[2][i]);
        assert!((u[3 * node] + 1e-6 * y).abs() < 1e-11, "{}", u[3 * node]);
        assert!((u[3 * node + 1] - 1e-6 * x).abs() < 1e-11);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_numbers() {
    let (device, tree) = (device(), tree());
    let run = |threads: usize| -> Vec<f32> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let clusters = random([7, CLUSTERS * 6], 1, &device).require_grad();
            let nodes = random([7, NODES * 3], 2, &device);
            let u = rigid_motions(
                clusters.clone().reshape([7, CLUSTERS, 6]),
                nodes.reshape([7, NODES, 3]),
                &tree,
            );
            let gradient = clusters.grad(&u.clone().powi_scalar(2).sum().backward()).unwrap();
            u.into_data().iter::<f32>().chain(gradient.into_data().iter::<f32>()).collect()
        })
    };
    assert_eq!(run(1), run(3));
}
