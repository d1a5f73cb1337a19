//! One volume ratio per patch: derivatives, and the cure of locking.

use crate::support::{gravity, parameters};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Magnitude, Scene, Support};
use sinew_fem::{Options, Solver};
use sinew_mesh::box_tetrahedra;

/// Central differences with this step carry an error of about its square times the third derivative.
const STEP: f64 = 1e-5;

fn beam(mesh: sinew_mesh::TetMesh, weight: f64) -> Scene {
    Scene {
        name: "beam".into(),
        parameters: parameters(&["mu", "lambda"]),
        loads: gravity(weight),
        supports: vec![Support::clamped("x_min")],
        ..Scene::new(mesh, NeoHookean)
    }
}

#[test]
fn forces_and_stiffness_are_derivatives_of_the_energy() {
    let mesh = box_tetrahedra([2.0, 1.0, 1.0], [3, 2, 2]);
    let body = beam(mesh, 0.0).averaged().lower().unwrap();
    let theta = [1.0, 50.0];
    let size = body.prescribed.len();
    let u: Vec<f64> = (0..size).map(|i| 0.03 * (((i * 7919) % 23) as f64 / 11.0 - 1.0)).collect();
    let direction: Vec<f64> = (0..size).map(|i| ((i * 104_729) % 17) as f64 / 8.0 - 1.0).collect();
    let moved =
        |by: f64| -> Vec<f64> { u.iter().zip(&direction).map(|(u, d)| u + by * d).collect() };
    let at = |u: &[f64]| {
        let mut gradient = vec![0.0; size];
        (body.value_and_gradient(u, &theta, &mut gradient), gradient)
    };
    let (energy, gradient) = at(&u);
    assert!((energy / body.value(&u, &theta) - 1.0).abs() < 1e-13);
    let (up, down) = (at(&moved(STEP)), at(&moved(-STEP)));
    let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
    let difference = (up.0 - down.0) / (2.0 * STEP);
    assert!((slope - difference).abs() < 1e-7 * slope.abs(), "{slope} {difference}");

    let mut solver = Solver::new(&body).unwrap();
    let product = solver.stiffness_times(&u, &theta, &direction).unwrap();
    let largest = product.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    for (i, product) in product.iter().enumerate() {
        let difference = (up.1[i] - down.1[i]) / (2.0 * STEP);
        assert!((product - difference).abs() < 1e-6 * largest, "{i}: {product} {difference}");
    }
}

/// The tip of a nearly incompressible beam: its deflection hardly depends on the bulk modulus with one volume ratio
/// per patch; linear tetrahedra alone lose most of it.
#[test]
fn patches_cure_locking() {
    let scene = beam(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), 1.0);
    let tip = scene.mesh.node_sets()["x_max"][0];
    let deflection = |averaged: bool, bulk: f64| {
        let body = if averaged { scene.clone().averaged() } else { scene.clone() }.lower().unwrap();
        let mut solver = Solver::new(&body).unwrap();
        let solution = solver.solve(&[75.0, bulk], &Options::default()).unwrap();
        assert!(solution.is_stable());
        -solution.displacement[3 * tip + 2]
    };
    let [soft, stiff] = [7.5e3, 7.5e5].map(|bulk| deflection(true, bulk));
    assert!((soft / stiff - 1.0).abs() < 0.01, "{soft} {stiff}");
    let [locked, worse] = [7.5e3, 7.5e5].map(|bulk| deflection(false, bulk));
    assert!(locked < 0.5 * soft && worse < 0.1 * stiff, "{locked} {worse}");
}

#[test]
fn a_follower_on_a_loose_rim_takes_averaged_volume_ratios() {
    let tip = |cells: usize, averaged: bool| {
        let mesh = box_tetrahedra([4.0, 1.0, 1.0], [8 * cells, 2 * cells, 2 * cells]);
        let node = mesh.points.iter().position(|&x| x == [4.0, 0.0, 0.0]).unwrap();
        let load = Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(0.01) };
        let scene = Scene { loads: vec![load], ..beam(mesh, 0.0) };
        let scene = scene.loose_rims();
        let body = if averaged { scene.averaged().lower() } else { scene.lower() }.unwrap();
        let mut solver = Solver::new(&body).unwrap();
        let solution = solver.solve(&[1.0, 200.0], &Options::default()).unwrap();
        assert!(solution.residual <= 1e-9 * solution.force_scale);
        assert_eq!(body.patches.is_empty(), !averaged);
        solution.displacement[3 * node + 2]
    };
    // Linear tetrahedra lock at a bulk modulus of 200 times the shear modulus; averaged ones are near to their own finer mesh.
    let [plain, averaged, finer] = [tip(1, false), tip(1, true), tip(2, true)];
    println!("{plain} {averaged} {finer}");
    assert!(averaged > 1.5 * plain && (averaged / finer - 1.0).abs() < 0.25);
}

#[test]
fn a_held_rim_gives_the_same_averaged_by_balance_and_by_potential() {
    let load = Load::Pressure { facets: "z_max".into(), magnitude: Magnitude::Fixed(0.3) };
    let supports = ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped).to_vec();
    let mesh = box_tetrahedra([4.0, 1.0, 1.0], [8, 2, 2]);
    let scene = Scene { loads: vec![load], supports, ..beam(mesh, 0.0) };
    let scene = scene.averaged();
    let (balance, body) = (scene.clone().loose_rims().lower().unwrap(), scene.lower().unwrap());
    let options = Options::default();
    let balanced = Solver::new(&balance).unwrap().solve(&[1.0, 50.0], &options).unwrap();
    let minimum = Solver::new(&body).unwrap().solve(&[1.0, 50.0], &options).unwrap();
    assert!(crate::support::difference(&balanced.displacement, &minimum.displacement) < 1e-8);
}
