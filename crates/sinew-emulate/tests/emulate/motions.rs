//! Rigid motions of nested clusters: clusters, derivatives of composed motions, interpolation between solved states.

use sinew_emulate::Body;
use sinew_emulate::coordinates::{Anchor, Anchors, CoordinateError, MotionTree, Motions, halves};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Parameter, Scene, Support};
use sinew_fem::Solver;
use sinew_mesh::box_tetrahedra;

/// A cube of eight nodes, four of them clamped.
fn cube() -> Body {
    Scene::new(box_tetrahedra([1.0; 3], [1; 3]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=2.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=2.0))
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap()
}

/// Motions of the cube about rest.
fn about_rest(body: &Body, clusters: &[Vec<usize>]) -> Result<Motions, CoordinateError> {
    Motions::about(&vec![0.0; 3 * body.nodes], clusters, body, &body.centre())
}

#[test]
fn every_cluster_has_two_to_four_nodes_and_every_layer_half_the_clusters() {
    for nodes in 1..200 {
        let at = |i: usize| [(i * 7 % 13) as f64, (i * 5 % 11) as f64, 0.0];
        let clusters = halves(&(0..nodes).map(at).collect::<Vec<_>>());
        let count = |layer: &Vec<usize>| 1 + layer.iter().max().unwrap();
        let counts: Vec<usize> = clusters.iter().map(count).collect();
        let leaves = std::iter::once(nodes).chain(counts.iter().copied());
        for ((layer, &count), leaves) in clusters.iter().zip(&counts).zip(leaves) {
            assert_eq!(layer.len(), leaves);
            assert!((0..count).all(|cluster| layer.contains(&cluster)), "{layer:?}");
        }
        assert!(counts.windows(2).all(|pair| pair[0] == 2 * pair[1]));
        assert_eq!(counts.last(), Some(&1));
        let size = |cluster| clusters[0].iter().filter(|&&of| of == cluster).count();
        assert!((0..counts[0]).all(|c| nodes < 4 || (2..=4).contains(&size(c))), "{nodes}");
    }
}

#[test]
fn clusters_that_belong_to_no_body_are_refused() {
    let body = cube();
    let refused = |layer: [usize; 8]| about_rest(&body, &[layer.to_vec()]).unwrap_err();
    let seven = about_rest(&body, &[vec![0; 7]]).unwrap_err();
    assert!(matches!(seven, CoordinateError::Count { found: 7, expected: 8, .. }), "{seven}");
    let empty = refused([0, 0, 0, 2, 2, 2, 2, 2]);
    assert_eq!(empty, CoordinateError::None("a cluster without leaves"));
    let many = refused([0, 17, 1, 1, 1, 1, 1, 1]);
    assert_eq!(many, CoordinateError::None("more clusters than leaves"));
    let two = about_rest(&body, &[vec![0, 0, 0, 0, 1, 1, 1, 1], vec![0, 0]]).unwrap();
    assert_eq!(two.tree().cluster_parents, [Some(2), Some(2), None]);
}

/// `(P S)ᵀ K (P S)`, with the stiffness `K` of the solver, is one on the motions that cost energy, zero on the others.
#[test]
fn a_unit_output_costs_an_energy_of_one_half() {
    let foundation = Load::Foundation { facets: "x_max".into(), normal: 3.0, tangential: 0.5 };
    let body = Scene::new(box_tetrahedra([3.0, 1.0, 1.0], [3, 1, 1]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=2.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=2.0))
        .load(foundation)
        .support(Support::roller_on_plane("x_min", [1.0, 0.0, 2.0]))
        .lower()
        .unwrap();
    let motions = about_rest(&body, &halves(&body.positions)).unwrap();
    let (tree, mut solver) = (motions.tree(), Solver::new(&body).unwrap());
    let (rest, length) = (vec![0.0; 3 * body.nodes], tree.of_clusters() + 3 * body.nodes);
    let clusters = (0..tree.of_clusters()).step_by(6).map(|first| first..first + 6);
    let nodes = (tree.of_clusters()..length).step_by(3).map(|first| first..first + 3);
    for outputs in clusters.chain(nodes) {
        let moved = |output: usize| {
            let mut change = vec![0.0; length];
            change[output] = 1.0;
            let moved = tree.tangent(&vec![0.0; length], &change);
            let mut free = rest.clone();
            for dof in body.free_degrees_of_freedom() {
                body.frames.add(dof, body.frames.component(dof, &moved), &mut free);
            }
            free
        };
        let moved: Vec<_> = outputs.map(moved).collect();
        let size = moved.len();
        let mut forces = |u: &Vec<f64>| solver.stiffness_times(&rest, &body.centre(), u).unwrap();
        let forces: Vec<_> = moved.iter().map(&mut forces).collect();
        let cost =
            nalgebra::DMatrix::from_fn(size, size, |i, j| sinew_num::dot(&moved[i], &forces[j]));
        assert!((&cost * &cost - &cost).amax() < 1e-10 && cost.trace() > 1.99, "{cost}");
    }
}

/// The unit matrix.
fn unit<const N: usize>() -> [[f64; N]; N] {
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))))
}

#[test]
fn slopes_of_turns_are_smooth_from_no_angle_to_full_ones() {
    // The node at each unit vector moves by a column of the rotation less the identity.
    let tree = MotionTree {
        node_parents: vec![0; 3],
        cluster_parents: vec![None],
        positions: unit::<3>().to_vec(),
        centres: vec![[0.0; 3]],
        node_scales: vec![unit(); 3],
        cluster_scales: vec![unit()],
    };
    let axis = [0.48, -0.6, 0.64];
    let moment: Vec<f64> = (0..9).map(|at| ((3 * (at % 3) + at / 3) as f64).cos()).collect();
    let outputs = |w: [f64; 3]| {
        let mut outputs = vec![0.0; 15];
        outputs[3..6].copy_from_slice(&w);
        outputs
    };
    let value = |w: [f64; 3]| {
        let moved = tree.moved(&outputs(w));
        moved.iter().zip(&moment).map(|(u, m)| u * m).sum::<f64>()
    };
    for angle in [0.0, 1e-9, 1e-3, 0.3162, 0.3163, 1.0, 3.0, std::f64::consts::PI, 6.0] {
        let w = axis.map(|a| angle * a);
        let slope = &tree.pull_back(&outputs(w), &moment)[3..6];
        for i in 0..3 {
            const STEP: f64 = 1e-5;
            let at = |step: f64| {
                let mut w = w;
                w[i] += step;
                value(w)
            };
            let finite = (at(STEP) - at(-STEP)) / (2.0 * STEP);
            assert!((finite - slope[i]).abs() < 1e-8, "angle {angle}: {finite} {}", slope[i]);
        }
    }
}

fn wave(seed: f64) -> f64 {
    (seed * 1.7).sin()
}

fn mixing<const N: usize>(seed: f64) -> [[f64; N]; N] {
    let unit = unit::<N>();
    std::array::from_fn(|i| {
        std::array::from_fn(|j| unit[i][j] + 0.2 * wave(seed + (3 * i + j) as f64))
    })
}

#[test]
fn tangents_are_derivatives() {
    const NODES: usize = 5;
    const CLUSTERS: usize = 4;
    // Five nodes in two clusters, these in one, and that beside a lonely root.
    let point = |seed: usize| std::array::from_fn(|i| 7.0 * wave((3 * seed + i) as f64));
    let tree = MotionTree {
        node_parents: vec![0, 0, 1, 1, 3],
        cluster_parents: vec![Some(2), Some(2), None, None],
        positions: (0..NODES).map(point).collect(),
        centres: (10..10 + CLUSTERS).map(point).collect(),
        node_scales: (0..NODES).map(|n| mixing(n as f64)).collect(),
        cluster_scales: (0..CLUSTERS).map(|c| mixing(10.0 + c as f64)).collect(),
    };
    let length = 6 * CLUSTERS + 3 * NODES;
    let values =
        |seed: f64| -> Vec<f64> { (0..length).map(|i| wave(seed + 2.3 * i as f64)).collect() };
    let moved = |outputs: &[f64], change: &[f64], step: f64| {
        let pairs = outputs.iter().zip(change);
        tree.moved(&pairs.map(|(y, change)| y + step * change).collect::<Vec<_>>())
    };
    const STEP: f64 = 1e-6;
    for seed in [3.0, 4.0] {
        let (outputs, change, cotangent) = (values(seed), values(seed + 2.0), values(seed + 4.0));
        let found = tree.tangent(&outputs, &change);
        let (ahead, behind) = (moved(&outputs, &change, STEP), moved(&outputs, &change, -STEP));
        for ((a, b), found) in ahead.iter().zip(&behind).zip(&found) {
            assert!(((a - b) / (2.0 * STEP) - found).abs() < 1e-7, "{found}");
        }
        // The pull-back is the transpose of the tangent.
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let back = tree.pull_back(&outputs, &cotangent[..3 * NODES]);
        let (forward, backward) = (product(&found, &cotangent), product(&change, &back));
        assert!((forward - backward).abs() < 1e-12 * forward.abs(), "{forward} {backward}");
    }
}

/// Two components of a field with their derivatives: by each of two parameters, and by each two of these.
fn given([x, y]: [f64; 2]) -> [[f64; 2]; 6] {
    let (e, s) = ((0.5 * x - 0.3 * y).exp(), (0.4 * x + 0.7 * y).sin());
    let c = (0.4 * x + 0.7 * y).cos();
    [
        [e, s],
        [0.5 * e, 0.4 * c],
        [-0.3 * e, 0.7 * c],
        [0.25 * e, -0.16 * s],
        [-0.15 * e, -0.28 * s],
        [0.09 * e, -0.49 * s],
    ]
}

/// State of a body whose last node moves by the field.
fn state(body: &Body, at: [f64; 2]) -> Anchor {
    // Coefficients of squares are halves of derivatives.
    let parts = [1.0, 1.0, 1.0, 0.5, 1.0, 0.5];
    let change = |([a, b], part): ([f64; 2], f64)| {
        let mut change = vec![0.0; 3 * body.nodes];
        change[3 * body.nodes - 3..][..2].copy_from_slice(&[part * a, part * b]);
        change
    };
    Anchor { at: at.to_vec(), changes: given(at).into_iter().zip(parts).map(change).collect() }
}

#[test]
fn a_field_and_its_derivatives_are_met_at_every_anchor_and_nearly_between() {
    let places = [[0.0, 0.0], [1.2, -1.0], [-1.4, 0.7], [0.6, 1.5]];
    let body = cube();
    let motions = about_rest(&body, &halves(&body.positions)).unwrap();
    let motions = motions.through(&places.map(|place| state(&body, place))).unwrap();
    let anchors = &**motions.anchors().unwrap();
    let at = |x: [f64; 2], along: Option<&[f64]>| {
        let field = anchors.at_parameters(&x, along).unwrap();
        assert!(field[..field.len() - 3].iter().all(|u| u.abs() < 1e-12));
        [field[field.len() - 3], field[field.len() - 2]]
    };
    for place in places {
        let (found, given) = (at(place, None), given(place));
        let slopes = [[1.0, 0.0], [0.0, 1.0]].map(|p| at(place, Some(&p)));
        for i in 0..2 {
            // The nugget times weights of millions: the fields are smooth over the length.
            assert!((found[i] - given[0][i]).abs() < 1e-3, "{found:?} {given:?}");
            assert!((slopes[0][i] - given[1][i]).abs() < 1e-2, "{slopes:?} {given:?}");
            assert!((slopes[1][i] - given[2][i]).abs() < 1e-2, "{slopes:?} {given:?}");
        }
        assert!(anchors.variance(&place).unwrap() < 1e-4);
    }
    let between = [0.4, -0.3];
    let (found, truth) = (at(between, None), given(between)[0]);
    assert!((0..2).all(|i| (found[i] - truth[i]).abs() < 2e-3), "{found:?} {truth:?}");
    assert!(anchors.variance(&[40.0, 40.0]).unwrap() > 0.9);
    // Stored ones are the same to the bit.
    let text = serde_json::to_string(anchors).unwrap();
    assert_eq!(&serde_json::from_str::<Anchors>(&text).unwrap(), anchors);
    let fewer = text.replace("\"anchors\":4", "\"anchors\":3");
    assert!(fewer != text && serde_json::from_str::<Anchors>(&fewer).is_err());
}

#[test]
fn anchors_that_coincide_or_are_not_finite_are_refused() {
    let body = cube();
    let through = |states: &[Anchor]| {
        about_rest(&body, &halves(&body.positions)).unwrap().through(states).unwrap_err()
    };
    let whole = state(&body, [0.1, 0.2]);
    let error = through(&[whole.clone(), whole.clone()]);
    assert!(error.to_string().contains("same parameters"), "{error}");
    let mut lost = whole;
    lost.changes[0][20] = f64::NAN;
    let error = through(&[lost]);
    assert!(matches!(error, CoordinateError::NotFinite { .. }), "{error}");
}
