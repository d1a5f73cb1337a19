//! One volume ratio per patch: derivatives, and the cure of locking.

mod support;

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Scene, Support, Units};
use sinew_fem::{Options, Solver};
use sinew_mesh::box_tetrahedra;
use support::{gravity, parameters};

/// Central differences with this step carry an error of about its square times the third derivative.
const STEP: f64 = 1e-5;

fn beam(mesh: sinew_mesh::TetMesh, weight: f64) -> Scene<NeoHookean, 0> {
    Scene {
        name: "beam".into(),
        units: Units::mm_kpa(),
        mesh,
        law: NeoHookean,
        directions: vec![],
        parameters: parameters(&["mu", "lambda"]),
        loads: gravity(weight),
        supports: vec![Support::clamped("x_min")],
    }
}

#[test]
fn forces_and_stiffness_are_derivatives_of_the_energy() {
    let mesh = box_tetrahedra([2.0, 1.0, 1.0], [3, 2, 2]);
    let body = beam(mesh, 0.0).lower_averaged().unwrap();
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
    let tip = scene.mesh.node_sets["x_max"][0];
    let deflection = |averaged: bool, bulk: f64| {
        let body = if averaged { scene.lower_averaged() } else { scene.lower() }.unwrap();
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
