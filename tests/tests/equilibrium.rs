//! Equality of the solver's solution and the minimum of the potential that physics-informed training reads.

mod support;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sinew_energy::laws::HolzapfelOgden;
use sinew_energy::{Barriers, Body, Law, Load, Magnitude, Scene, Support};
use sinew_fem::{Options, Solution, Solver};
use sinew_gnn::Potential;
use sinew_mesh::box_tetrahedra;
use support::{hanging, norm, stiffness};

/// Nodal forces that are left, relative to loads and reactions: the solver stops at their rounding.
const RESIDUAL: f64 = 1e-10;
/// Relative difference of two sums of the same energies.
const ENERGY: f64 = 1e-12;

/// Free degrees of freedom moved at random, by up to `size` [mm].
fn perturbed(prescribed: &[Option<f64>], u: &[f64], size: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    u.iter()
        .zip(prescribed)
        .map(|(&u, fixed)| fixed.unwrap_or_else(|| u + size * random.random_range(-1.0..1.0)))
        .collect()
}

/// Solves, then reads the training potential only.
fn check(potential: &Body, theta: &[f64]) -> Solution {
    let solution = Solver::new(potential).unwrap().solve(theta, &Options::default()).unwrap();
    assert!(solution.is_stable());
    let guarded = potential.clone().with_barriers(Barriers::default());
    let training: &dyn Potential = &guarded;

    let mut gradient = vec![0.0; training.degrees_of_freedom()];
    let energy = training.value_and_gradient(&solution.displacement, theta, &mut gradient);
    assert!((energy / solution.energy - 1.0).abs() < ENERGY, "{energy} {}", solution.energy);
    let free = potential.free_degrees_of_freedom();
    let residual = norm(free.iter().map(|&i| gradient[i])) / solution.force_scale;
    assert!(residual < RESIDUAL, "{residual:e}");

    // From a thousandth to a tenth of the smallest cells' size, 1 mm: the energy grows, by the square near by.
    for seed in 0..5 {
        let growth = [1e-3, 2e-3, 1e-2, 1e-1].map(|size| {
            let moved = perturbed(&potential.prescribed, &solution.displacement, size, seed);
            training.value_and_gradient(&moved, theta, &mut gradient) - energy
        });
        assert!(growth[0] > 0.0 && growth.is_sorted(), "{growth:?}");
        let ratio = growth[1] / growth[0];
        assert!((ratio - 4.0).abs() < 0.05, "{ratio}: the energy does not grow by the square");
    }
    solution
}

#[test]
fn under_gravity() {
    let potential = hanging(box_tetrahedra([10.0, 2.0, 2.0], [10, 2, 2]), 0.04).lower().unwrap();
    let solution = check(&potential, &[10.0, 12.0]);
    let sag = solution.displacement.iter().fold(0.0f64, |most, u| most.max(u.abs()));
    assert!(sag > 1.0, "the test is about large deflections, not {sag} mm");
}

#[test]
fn under_follower_pressure() {
    let scene = Scene {
        name: "pressed block".into(),
        parameters: ["mu", "lambda", "p"].map(|name| stiffness(name, [0.1, 20.0])).into(),
        loads: vec![Load::Pressure { facets: "z_max".into(), magnitude: Magnitude::Theta(2) }],
        // The rim of the pressed face is held, so that the pressure has a potential.
        supports: ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped).into(),
        ..hanging(box_tetrahedra([4.0, 4.0, 2.0], [4, 4, 2]), 0.0)
    };
    let solution = check(&scene.lower().unwrap(), &[5.0, 5.0, 3.0]);
    assert!(solution.least_volume_ratio < 0.9, "{}", solution.least_volume_ratio);
}

#[test]
fn with_fibres() {
    let mesh = box_tetrahedra([8.0, 2.0, 2.0], [8, 2, 2]);
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let fibres = vec![[[cos, sin, 0.0]]; mesh.cells.len()];
    let tissue = HolzapfelOgden.nearly_incompressible(10.0).along(fibres);
    let scene = Scene {
        name: "muscle strip".into(),
        parameters: ["a", "b", "a_f", "b_f"].map(|name| stiffness(name, [0.1, 10.0])).into(),
        loads: vec![Load::Traction { facets: "x_max".into(), value: [0.2, 0.0, 0.02] }],
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(mesh, tissue)
    };
    check(&scene.lower().unwrap(), &[0.5, 5.0, 3.0, 3.0]);
}

#[test]
fn a_scene_that_went_through_a_file_has_the_same_equilibrium() {
    let mesh = box_tetrahedra([10.0, 2.0, 2.0], [5, 1, 2]);
    let bytes = sinew_mesh::to_vtu(&mesh).unwrap();
    let (read, _) = sinew_mesh::parse_mesh::<4>("beam.vtu", &bytes).unwrap();
    let solve = |mesh| {
        let potential: Body = hanging(mesh, 0.02).lower().unwrap();
        Solver::new(&potential).unwrap().solve(&[9.0, 15.0], &Options::default()).unwrap()
    };
    assert_eq!(solve(read).displacement, solve(mesh).displacement);
}
