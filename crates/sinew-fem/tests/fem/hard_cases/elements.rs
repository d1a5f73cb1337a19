//! Quadratic, mixed, averaged, plane and hexahedral elements in hard places.

use crate::distort::Distort as _;
use crate::hard_cases::bodies::scene;
use crate::hard_cases::checks::*;
use sinew_energy::laws::{ByYoungPoisson, NeoHookean};
use sinew_energy::{Body, Load, Scene, Support};
use sinew_fem::{Options, SolveError, Solver};
use sinew_mesh::{AnyMesh, TriangleMesh, box_hexahedra, box_tetrahedra, rectangle_triangles};
use std::f64::consts::PI;

fn displacement(potential: &Body, theta: &[f64]) -> Vec<f64> {
    let solution = Solver::new(potential).unwrap().solve(theta, &Options::default());
    let solution = solution.unwrap_or_else(|error| panic!("{error}"));
    println!(
        "{} nodes: {} iterations, {:.1} ms",
        potential.nodes_per_cell,
        solution.iterations(),
        1e3 * solution.seconds
    );
    assert!(solution.is_stable() && solution.least_volume_ratio > 0.0);
    solution.displacement
}

/// Tip deflection of a cantilever 8×1×1 relative to beam theory with shear, `FL³/(3EI) + 6FL/(5GA)`, for a force
/// so small that the theory is linear.
fn deflection(
    mesh: impl Into<AnyMesh>,
    poisson: f64,
    solve: impl FnOnce(&Scene) -> Vec<f64>,
) -> f64 {
    let (force, length, young) = (1e-7, 8.0_f64, 3.0);
    let load = Load::Traction { facets: "x_max".into(), value: [0.0, 0.0, -force] };
    let scene = Scene { loads: vec![load], ..scene(ByYoungPoisson(NeoHookean), mesh) };
    let tip = scene.mesh.node_sets()["x_max"][0];
    let shear = young / (2.0 * (1.0 + poisson));
    let theory = force * (length.powi(3) / (3.0 * young / 12.0) + 1.2 * length / shear);
    let part = -solve(&scene)[3 * tip + 2] / theory;
    println!("ν = {poisson}, {}: {part:.3} of beam theory", scene.mesh.element().plural);
    part
}

/// Share of beam theory that elements without locking reach on a coarse mesh, its clamp being stiffer than the theory's.
const FREE_OF_LOCKING: std::ops::Range<f64> = 0.9..1.02;

#[test]
fn mixed_elements_bend_incompressibly_where_linear_ones_lock() {
    let poisson = 0.499999;
    let tetrahedra = || box_tetrahedra([8.0, 1.0, 1.0], [16, 2, 2]);
    let linear = deflection(tetrahedra(), poisson, |scene| {
        displacement(&scene.lower().unwrap(), &[3.0, poisson])
    });
    let mixed = deflection(tetrahedra().quadratic(), poisson, |scene| {
        let body = scene.clone().mixed().lower().unwrap();
        let mut solver = Solver::new(&body).unwrap();
        let solution = solver.solve(&[3.0, poisson], &Options::default()).unwrap();
        solution.displacement
    });
    assert!(linear < 0.1 && FREE_OF_LOCKING.contains(&mixed), "{linear} {mixed}");
}

#[test]
fn hexahedra_with_one_volume_ratio_do_not_lock_at_poisson_ratio_0_499999() {
    let poisson = 0.499999;
    let hexahedra = || box_hexahedra([8.0, 1.0, 1.0], [16, 4, 4]);
    let full = deflection(hexahedra(), poisson, |scene| {
        displacement(&scene.lower().unwrap(), &[3.0, poisson])
    });
    let averaged = deflection(hexahedra(), poisson, |scene| {
        displacement(&scene.clone().averaged().lower().unwrap(), &[3.0, poisson])
    });
    assert!(full < 0.7 && averaged > 0.85 && averaged < 1.02, "{full} {averaged}");
}

#[test]
fn patches_of_linear_tetrahedra_soften_what_locks_at_poisson_ratio_0_4999() {
    let poisson = 0.4999;
    let tetrahedra = || box_tetrahedra([8.0, 1.0, 1.0], [16, 4, 4]);
    let linear = deflection(tetrahedra(), poisson, |scene| {
        displacement(&scene.lower().unwrap(), &[3.0, poisson])
    });
    let averaged = deflection(tetrahedra(), poisson, |scene| {
        displacement(&scene.clone().averaged().lower().unwrap(), &[3.0, poisson])
    });
    assert!(averaged > 2.0 * linear && averaged < 1.02, "{linear} {averaged}");
}

/// A cube between rollers, compressed by nine tenths, against `μ(t² − 1) + λ ln(s t²) = 0` with λ = 0: no bulge.
fn compressed(mesh: impl Into<AnyMesh>) {
    let roller = |axis: usize| std::array::from_fn(|i| (i == axis).then_some(0.0));
    let supports = vec![
        Support::uniform("x_min", roller(0)),
        Support::uniform("y_min", roller(1)),
        Support::uniform("z_min", roller(2)),
        Support::uniform("x_max", [Some(-0.9), None, None]),
    ];
    let cube = Scene { supports, ..scene(NeoHookean, mesh) }.lower().unwrap();
    let exact: Vec<_> = cube.positions.iter().flat_map(|x| [-0.9 * x[0], 0.0, 0.0]).collect();
    let off = difference(&displacement(&cube, &[1.0, 0.0]), &exact);
    assert!(off < 1e-9, "{}: {off:e}", cube.element().plural);
}

#[test]
fn quadratic_tetrahedra_and_hexahedra_are_compressed_by_90_percent_exactly() {
    compressed(box_tetrahedra([1.0; 3], [2; 3]).distorted(1, 0.1).quadratic());
    compressed(box_hexahedra([1.0; 3], [2; 3]).distorted(1, 0.1));
}

#[test]
fn a_quadratic_body_turned_by_180_degrees_has_no_energy() {
    let mut mesh = box_tetrahedra([1.0; 3], [2; 3]).quadratic();
    let boundary: Vec<_> = mesh.node_sets.values().flatten().copied().collect();
    mesh.node_sets.insert("boundary".into(), boundary);
    let (sine, cosine) = PI.sin_cos();
    let turn = |[x, y, _]: [f64; 3]| [cosine * x - sine * y - x, sine * x + cosine * y - y, 0.0];
    let supports = vec![Support::moved("boundary", &mesh, turn)];
    let exact: Vec<_> = mesh.points.iter().flat_map(|&x| turn(x)).collect();
    let cube = Scene { supports, ..scene(NeoHookean, mesh) }.lower().unwrap();
    let solution = Solver::new(&cube).unwrap().solve(&[1.0, 1.0], &Options::default()).unwrap();
    assert!(difference(&solution.displacement, &exact) < 1e-12);
    assert!(solution.energy.abs() < 1e-14 && solution.is_stable());
}

#[test]
fn a_quadratic_tetrahedron_with_a_middle_node_far_off_is_refused() {
    let mut mesh = box_tetrahedra([1.0; 3], [1; 3]).quadratic();
    let middle = mesh.cells[0][4];
    mesh.points[middle] = [3.0, 3.0, 3.0];
    let error = scene(NeoHookean, mesh).lower().unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("is folded over at its node") && text.contains("its Jacobian there is -")
    );
}

#[test]
fn a_hexahedron_that_is_listed_twice_or_upside_down_is_refused() {
    let mut mesh = box_hexahedra([1.0; 3], [1; 3]);
    let cell = mesh.cells[0];
    mesh.cells.push(cell);
    let error = scene(NeoHookean, mesh.clone()).lower().unwrap_err();
    assert!(error.to_string().starts_with("cells 0 and 1 lie on the same side"), "{error}");
    mesh.cells.pop();
    // Upside down.
    mesh.cells[0].rotate_left(4);
    let error = scene(NeoHookean, mesh).lower().unwrap_err();
    assert!(error.to_string().starts_with("cell 0 is folded over at its node"), "{error}");
}

#[test]
fn triangles_on_a_shared_node_turn_about_it_and_those_on_an_edge_do_not() {
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]];
    let hinged = |cells| {
        let mut mesh = TriangleMesh::new(points.clone(), cells).unwrap();
        mesh.node_sets.insert("x_min".into(), vec![0, 2]);
        let body = scene(NeoHookean, mesh).lower().unwrap();
        Solver::new(&body).map(|_| ())
    };
    match hinged(vec![[0, 1, 2], [1, 3, 4]]) {
        Err(SolveError::FreeToMove { nodes: 3, modes, .. }) => {
            assert_eq!(
                modes.iter().map(ToString::to_string).collect::<Vec<_>>(),
                ["rotation about z"]
            );
        }
        other => panic!("expected a hinge, got {other:?}"),
    }
    assert_eq!(hinged(vec![[0, 1, 2], [1, 4, 2], [1, 3, 4]]), Ok(()));
}

#[test]
fn a_strip_in_plane_strain_shears_as_the_closed_form_says() {
    let mut mesh = rectangle_triangles([2.0, 1.0], [4, 3]).quadratic();
    let boundary: Vec<_> = mesh.node_sets.values().flatten().copied().collect();
    mesh.node_sets.insert("boundary".into(), boundary);
    let shear = |[_, y, _]: [f64; 3]| [3.0 * y, 0.0, 0.0];
    let supports = vec![Support::moved("boundary", &mesh, shear)];
    let exact: Vec<_> = mesh.points.iter().flat_map(|&x| shear(x)).collect();
    let strip = Scene { supports, ..scene(NeoHookean, mesh) }.lower().unwrap();
    let solution = Solver::new(&strip).unwrap().solve(&[2.0, 1e4], &Options::default()).unwrap();
    assert!(difference(&solution.displacement, &exact) < 1e-10);
    // ψ = ½ μ γ² over an area of 2.
    assert_close(solution.energy, 0.5 * 2.0 * 9.0 * 2.0, 1e-12);
}
