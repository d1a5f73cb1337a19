//! Forces are derivatives of the energy and the stiffness of the forces, for each element with all that can act on it.

use crate::distort::Distort as _;
use crate::elements::scene::{scene, with_boundary, wobble};
use crate::shells::sphere_octant;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Magnitude, Scene};
use sinew_fem::Solver;
use sinew_mesh::{AnyMesh, box_hexahedra, box_tetrahedra, rectangle_triangles};

/// Central differences with this step err by about its square times the third derivative.
const STEP: f64 = 1e-5;
const THETA: [f64; 2] = [1.0, 20.0];

/// Held by springs alone, under weight, traction and a pressure all round, which all have a potential.
fn loaded(mesh: impl Into<AnyMesh>) -> Scene {
    let facets = || String::from("boundary");
    let loads = vec![
        Load::BodyForce([0.3, -0.2, 0.0]),
        Load::Traction { facets: facets(), value: [0.2, 0.1, 0.0] },
        Load::Foundation { facets: facets(), normal: 3.0, tangential: 0.7 },
        Load::Pressure { facets: facets(), magnitude: Magnitude::Fixed(0.8) },
    ];
    scene(NeoHookean, with_boundary(mesh), loads, vec![])
}

/// Along two directions: one through all nodes, and one of a single node.
fn check(name: &str, body: &Body, size: f64) {
    let count = body.prescribed.len();
    let mut u = wobble(count, size);
    let mut all: Vec<f64> = (0..count).map(|i| ((i * 104_729) % 17) as f64 / 8.0 - 1.0).collect();
    for (i, value) in body.prescribed.iter().enumerate() {
        if value.is_some() {
            (u[i], all[i]) = (0.0, 0.0);
        }
    }
    let mut one = vec![0.0; count];
    (0..2).for_each(|i| one[3 * (body.nodes / 2) + i] = 1.0 - 0.3 * i as f64);
    let at = |u: &[f64]| {
        let mut gradient = vec![0.0; count];
        (body.value_and_gradient(u, &THETA, &mut gradient), gradient)
    };
    let (energy, gradient) = at(&u);
    assert!(energy.is_finite(), "{name}");
    assert!((energy / body.value(&u, &THETA) - 1.0).abs() < 1e-12, "{name}");
    for direction in [all, one] {
        let moved =
            |by: f64| -> Vec<f64> { u.iter().zip(&direction).map(|(u, d)| u + by * d).collect() };
        let (up, down) = (at(&moved(STEP)), at(&moved(-STEP)));
        let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
        let difference = (up.0 - down.0) / (2.0 * STEP);
        let scale = gradient.iter().zip(&direction).map(|(g, d)| (g * d).abs()).sum::<f64>();
        assert!((slope - difference).abs() < 1e-7 * scale, "{name}: {slope} {difference}");

        let mut solver = Solver::new(body).unwrap();
        let product = solver.stiffness_times(&u, &THETA, &direction).unwrap();
        let largest = product.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for (i, product) in product.iter().enumerate() {
            let difference = (up.1[i] - down.1[i]) / (2.0 * STEP);
            let error = (product - difference).abs();
            assert!(error < 1e-6 * largest, "{name} {i}: {product} {difference}");
        }
    }
}

fn check_both(name: &str, mesh: impl Into<AnyMesh>, size: f64) {
    let scene = loaded(mesh);
    check(name, &scene.lower().unwrap(), size);
    check(&format!("{name} averaged"), &scene.averaged().lower().unwrap(), size);
}

#[test]
fn of_linear_tetrahedra() {
    check_both("P1", box_tetrahedra([1.0; 3], [2, 2, 3]).distorted(3, 0.3), 0.03);
}

#[test]
fn of_quadratic_tetrahedra() {
    check_both("P2", box_tetrahedra([1.0; 3], [1, 2, 1]).quadratic().distorted(3, 0.3), 0.02);
    let shell = sphere_octant([1.0, 2.0], [1, 1]);
    check_both("P2 shell", shell.quadratic_tetrahedra(), 0.02);
}

#[test]
fn of_hexahedra() {
    check_both("Q1", box_hexahedra([1.0; 3], [2, 2, 3]).distorted(3, 0.3), 0.03);
    check_both("Q1 shell", sphere_octant([1.0, 2.0], [1, 2]).hexahedra(), 0.03);
}

/// A side of a block under the pressure behind a lid over its rim.
#[test]
fn of_lids() {
    let lidded = |mesh: AnyMesh| {
        let mut scene = loaded(mesh);
        let magnitude = Magnitude::Fixed(0.8);
        scene.loads.push(Load::CavityPressure { facets: "z_max".into(), magnitude });
        scene
    };
    let block = || box_tetrahedra([1.0; 3], [2, 2, 1]).distorted(3, 0.3);
    check("P1", &lidded(block().into()).lower().unwrap(), 0.03);
    check("P1 averaged", &lidded(block().into()).averaged().lower().unwrap(), 0.03);
    check("P2", &lidded(block().quadratic().into()).lower().unwrap(), 0.02);
    let hexahedra = box_hexahedra([1.0; 3], [2, 2, 1]).distorted(3, 0.3);
    check("Q1", &lidded(hexahedra.into()).lower().unwrap(), 0.03);
}

#[test]
fn of_triangles() {
    let mesh = rectangle_triangles([1.0; 2], [3, 3]).distorted(3, 0.3);
    check_both("P1 triangles", mesh, 0.03);
    let mesh = rectangle_triangles([1.0; 2], [2, 2]).quadratic().distorted(3, 0.3);
    check_both("P2 triangles", mesh, 0.02);
}
