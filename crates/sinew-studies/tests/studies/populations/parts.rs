//! Hulls, plain networks, and solutions of coarse meshes on fine ones.

use hull::hull_volume;
use nalgebra::DMatrix;
use nested::solve_nested;
use perceptron::{Perceptron, Samples, Stopped};
use prolongation::Prolongation;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
use sinew_fem::{Options, Solver};

/// Files behind the reports of populations, which hold the errors of methods alone.
#[path = "../../../src/populations/inflated/hull.rs"]
mod hull;
#[path = "../../../src/populations/nested.rs"]
#[allow(dead_code)]
mod nested;
#[path = "../../../src/populations/inflated/perceptron.rs"]
#[allow(dead_code)]
mod perceptron;
#[path = "../../../src/populations/prolongation.rs"]
mod prolongation;

#[test]
fn hulls_have_the_volumes_of_a_box_and_of_a_ball() {
    // Many of the grid's points are on a face or an edge of the box.
    let grid = (0..125).map(|k| [k % 5, k / 5 % 5, k / 25].map(|i| f64::from(i) / 4.0));
    let turned = |[x, y, z]: [f64; 3]| [0.6 * x - 0.8 * y + 7.0, 0.8 * x + 0.6 * y, 3.0 * z];
    let grid: Vec<_> = grid.map(turned).collect();
    assert!((hull_volume(&grid) - 3.0).abs() < 1e-12); // rounding
    // Points of a spiral on a sphere; a hull of n of them lacks about 5.5 / n of its volume.
    let spiral = |k: u32| {
        let (z, angle) = (1.0 - (2.0 * f64::from(k) + 1.0) / 500.0, 2.399963 * f64::from(k));
        let r = (1.0 - z * z).sqrt();
        [r * angle.cos(), r * angle.sin(), z]
    };
    let ball = hull_volume(&(0..500).map(spiral).collect::<Vec<_>>());
    let missing = 1.0 - ball / (4.0 / 3.0 * std::f64::consts::PI);
    assert!((0.005..0.02).contains(&missing), "{missing}");
}

#[test]
fn nodes_on_lines_are_joined_by_others_until_they_span_the_body() {
    let bar = sinew_mesh::box_tetrahedra([10.0, 2.0, 2.0], [40, 1, 1]);
    let field = |[x, y, z]: &[f64; 3]| [y - z, x + 2.0 * z, 3.0 - y];
    let values: Vec<f64> = bar.points.iter().flat_map(field).collect();
    let points = [[5.01, 0.1, 0.1], [3.3, 1.0, 1.0], [9.9, 2.0, 0.0]];
    let found = Prolongation::new(&bar.points, &points).vectors(&values);
    let exact = points.iter().flat_map(field);
    assert!(found.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-10), "{found:?}");
}

#[test]
fn constants_are_met_where_nodes_lie_in_a_plane_and_points_beside_it() {
    let plane: Vec<[f64; 3]> = (0..16).map(|i| [f64::from(i % 4), f64::from(i / 4), 0.0]).collect();
    let found = Prolongation::new(&plane, &[[1.3, 1.7, 2.0]]);
    let values: Vec<f64> = plane.iter().flat_map(|x| [1.0, x[0], 3.0 * x[1]]).collect();
    let exact = [1.0, 1.3, 5.1];
    // Rounding of a dozen terms.
    assert!(found.vectors(&values).iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-12));
    // A single node gives a constant field.
    assert_eq!(Prolongation::new(&[[1.0; 3]], &[[2.0; 3]]).vectors(&[5.0; 3]), [5.0; 3]);
}

#[test]
fn a_coarse_solution_saves_iterations() {
    let [coarse, fine] = [[10, 2, 2], [40, 8, 8]].map(|cells| {
        let mesh = sinew_mesh::box_tetrahedra([10.0, 2.0, 2.0], cells);
        let scene = Scene::new(mesh, NeoHookean)
            .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
            .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
            .load(Load::BodyForce([0.0, 0.0, -0.5]))
            .support(Support::clamped("x_min"));
        scene.lower().expect("a beam")
    });
    let theta = [60.0, 60.0];
    let cold = Solver::new(&fine).unwrap().solve(&theta, &Options::default()).unwrap();
    let nested = solve_nested(&coarse, &fine, &theta).unwrap();
    assert!(nested.history.iterations.len() < cold.history.iterations.len());
    let off = nested.displacement.iter().zip(&cold.displacement).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-9);
}

fn samples(count: usize, seed: u64) -> Samples {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let x = DMatrix::from_fn(3, count, |_, _| 2.0 * random.random::<f32>() - 1.0);
    let y = DMatrix::from_fn(1, count, |_, k| 2.0 * x[(0, k)] * x[(1, k)] + x[(2, k)]);
    (x, y)
}

#[test]
fn a_network_learns_a_product_and_patience_stops_it_earlier() {
    let (training, validation) = (samples(200, 3), samples(50, 4));
    const EPOCHS: usize = 500;
    let found = Perceptron::train(&training, &validation, &[1, 20], EPOCHS, 5);
    let epochs: Vec<_> = found.iter().map(|stopped| stopped.epoch).collect();
    assert!(epochs[0] < epochs[1] && epochs[1] <= epochs[2] && epochs[2] == EPOCHS, "{epochs:?}");
    let errors = |of: fn(&Stopped) -> &Perceptron| -> Vec<f32> {
        let off = |network: &Perceptron| network.predict(&validation.0) - &validation.1;
        found.iter().map(|stopped| off(of(stopped)).norm_squared()).collect()
    };
    let [best, last] = [errors(|s| &s.best), errors(|s| &s.last)];
    assert!(best.iter().zip(&last).all(|(best, last)| best <= last), "{best:?} {last:?}");
    // Of a variance near 0.8; 5 % of the deviation are left.
    let share = best[2] / validation.1.norm_squared();
    assert!(share < 0.05f32.powi(2), "{share}");
    let early = || Perceptron::train(&training, &validation, &[], 10, 5).remove(0).last;
    assert_eq!(
        early().predict(&training.0),
        early().predict(&training.0),
        "the same seed, the same weights"
    );
}
