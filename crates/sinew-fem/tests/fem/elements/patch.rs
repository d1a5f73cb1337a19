//! Patch tests: a homogeneous deformation of the whole boundary is followed by the interior of any mesh.

use crate::distort::Distort as _;
use crate::elements::scene::{distance, roller, scene, with_boundary};
use sinew_energy::laws::{Guccione, HolzapfelOgden, NeoHookean, NeoHookeanShape};
use sinew_energy::{Law, Material, Prescribed, Scene, Support};
use sinew_fem::{Options, Solver};
use sinew_mesh::{AnyMesh, box_hexahedra, box_tetrahedra, rectangle_triangles};
use std::sync::Arc;

/// Rounding errors of positions in a unit cube, and of forces relative to the reactions.
const TOLERANCE: f64 = 1e-10;

/// Tolerance where GMRES solves the linear systems to a finite accuracy.
const BALANCE_TOLERANCE: f64 = 1e-9;

type Gradient = [[f64; 3]; 3];

/// Simple shear, a stretch with a change of volume, and a large turn with a shear, all in the plane.
const IN_PLANE: [Gradient; 3] = [
    [[1.0, 0.4, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[1.2, 0.1, 0.0], [-0.1, 0.9, 0.0], [0.0, 0.0, 1.0]],
    [[0.7, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]],
];
/// One more that leaves the plane.
const IN_SPACE: [Gradient; 4] =
    [IN_PLANE[0], IN_PLANE[1], IN_PLANE[2], [[1.1, 0.1, -0.2], [0.0, 0.9, 0.15], [0.1, 0.0, 1.05]]];
/// Fibres off all axes.
const FIBRE: [f64; 3] = [2.0 / 3.0, -2.0 / 3.0, 1.0 / 3.0];

fn motion(f: &Gradient) -> impl Fn([f64; 3]) -> [f64; 3] {
    |x| std::array::from_fn(|i| (0..3).map(|j| f[i][j] * x[j]).sum::<f64>() - x[i])
}

fn homogeneous(mesh: &AnyMesh, f: &Gradient) -> Vec<f64> {
    mesh.points().iter().flat_map(|&x| motion(f)(x)).collect()
}

/// The boundary moved by a homogeneous gradient.
fn deformed(mesh: &AnyMesh, f: &Gradient) -> Support {
    let rows = mesh.node_sets()["boundary"].iter();
    let rows = rows.map(|&node| motion(f)(mesh.points()[node]).map(Some));
    Support { nodes: "boundary".into(), displacement: Prescribed::PerNode(rows.collect()) }
}

/// The exact field balances, and the solver finds it.
fn check(name: &str, scene: Scene, theta: &[f64], f: &Gradient) {
    let supports = vec![deformed(&scene.mesh, f)];
    let scene = Scene { supports, ..scene };
    let body = scene.lower().unwrap();
    let exact = homogeneous(&scene.mesh, f);
    let mut forces = vec![0.0; exact.len()];
    body.value_and_gradient(&exact, theta, &mut forces);
    let reactions = forces.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let free = body.free_degrees_of_freedom();
    assert!(free.len() > exact.len() / 20, "{name}: hardly anything is free");
    let unbalanced = free.iter().fold(0.0, |m: f64, &i| m.max(forces[i].abs()));
    assert!(unbalanced < TOLERANCE * reactions, "{name} {f:?}: {unbalanced:e} of {reactions:e}");
    let solution = Solver::new(&body).unwrap().solve(theta, &Options::default()).unwrap();
    let error = distance(&solution.displacement, &exact);
    assert!(error < TOLERANCE, "{name} {f:?}: {error:e}");
}

/// All laws on one mesh; directions by cell and by node, where their senses alternate.
fn check_laws(name: &str, mesh: impl Into<AnyMesh>, deformations: &[Gradient], averaged: bool) {
    let mesh = with_boundary(mesh);
    let (cells, nodes) = (mesh.cell_count(), mesh.points().len());
    assert_ne!(cells, nodes, "the number of rows tells where directions are given");
    let of = |material: Arc<dyn Material>| {
        let scene = scene(material, mesh.clone(), vec![], vec![]);
        if averaged { scene.averaged() } else { scene }
    };
    let (ogden, guccione) =
        (HolzapfelOgden.nearly_incompressible(10.0), Guccione.nearly_incompressible(10.0));
    let opposite = FIBRE.map(|x| -x);
    let of_nodes = |node| [if node % 3 == 0 { FIBRE } else { opposite }];
    for f in deformations {
        check(name, of(NeoHookean.along(vec![])), &[1.0, 10.0], f);
        let theta = [0.5, 1.5, 1.0, 1.2];
        check(name, of(ogden.along(vec![[FIBRE]; cells])), &theta, f);
        check(name, of(ogden.along((0..nodes).map(of_nodes).collect())), &theta, f);
        let frames = guccione.along(vec![Guccione::frame(FIBRE); nodes]);
        check(name, of(frames), &[1.0, 3.0, 1.0, 2.0], f);
    }
}

#[test]
fn linear_tetrahedra() {
    let mesh = box_tetrahedra([1.0; 3], [3; 3]).distorted(7, 0.3);
    check_laws("P1", mesh.clone(), &IN_SPACE, false);
    check_laws("P1 patches", mesh, &IN_SPACE, true);
}

#[test]
fn quadratic_tetrahedra() {
    let mesh = box_tetrahedra([1.0; 3], [2, 2, 3]).distorted(7, 0.3).quadratic();
    check_laws("P2", mesh.clone(), &IN_SPACE, false);
    check_laws("P2 averaged", mesh, &IN_SPACE[1..2], true);
}

#[test]
fn hexahedra() {
    let mesh = box_hexahedra([1.0; 3], [3; 3]).distorted(7, 0.3);
    check_laws("Q1", mesh.clone(), &IN_SPACE, false);
    check_laws("Q1 averaged", mesh, &IN_SPACE, true);
}

#[test]
fn triangles() {
    let mesh = rectangle_triangles([1.0; 2], [4, 3]).distorted(7, 0.3);
    check_laws("P1 triangles", mesh.clone(), &IN_PLANE, false);
    check_laws("P1 triangle patches", mesh, &IN_PLANE, true);
    let straight = rectangle_triangles([1.0; 2], [3, 2]).distorted(7, 0.3).quadratic();
    check_laws("P2 triangles", straight, &IN_PLANE, false);
    let curved = rectangle_triangles([1.0; 2], [3, 2]).quadratic().distorted(7, 0.3);
    check_laws("curved P2 triangles", curved, &IN_PLANE, false);
}

/// Curved tetrahedra need a rule of degree three, which the mixed formulation brings; the degree two of
/// [`Scene::lower`] is exact for straight ones.
#[test]
fn curved_tetrahedra_with_a_field_of_pressure() {
    const COMPLIANCE: f64 = 0.01;
    let straight = box_tetrahedra([1.0; 3], [2; 3]).distorted(7, 0.3).quadratic();
    let curved = box_tetrahedra([1.0; 3], [2; 3]).quadratic().distorted(7, 0.3);
    for (name, mesh) in [("straight", straight), ("curved", curved)] {
        let mesh = with_boundary(mesh);
        for f in &IN_SPACE {
            let supports = vec![deformed(&mesh, f)];
            let scene = scene(NeoHookean, mesh.clone(), vec![], supports);
            let body = scene.mixed().lower().unwrap().with_compliance(COMPLIANCE).unwrap();
            let mut solver = Solver::new(&body).unwrap();
            let solution = solver.solve(&[1.0, 2.0], &Options::default()).unwrap();
            let error = distance(&solution.displacement, &homogeneous(&mesh, f));
            assert!(error < BALANCE_TOLERANCE, "{name} {f:?}: {error:e}");
            let change = determinant(f) - 1.0;
            let pressure = vec![change / COMPLIANCE; solution.pressure.len()];
            // The pressure is the change of volume over the compliance.
            let error = distance(&solution.pressure, &pressure);
            assert!(error < BALANCE_TOLERANCE / COMPLIANCE, "{name} {f:?}: {error:e}");
        }
    }
}

/// An incompressible bar: `P₁₁ = μ(s − s⁻²)` (R. S. Rivlin, Phil. Trans. R. Soc. A 241, 1948).
#[test]
fn an_incompressible_bar_stretches_as_rivlin_says() {
    const STRETCH: f64 = 1.5;
    let mesh = box_tetrahedra([1.0; 3], [2; 3]).distorted(7, 0.3).quadratic();
    let [end, corner] =
        [[1.0, 0.5, 0.5], [1.0; 3]].map(|at| crate::elements::scene::node_at(&mesh.points, at));
    let supports = vec![
        roller("x_min", 0),
        roller("y_min", 1),
        roller("z_min", 2),
        Support::uniform("x_max", [Some(STRETCH - 1.0), None, None]),
    ];
    let far = mesh.node_sets["x_max"].clone();
    let bar = scene(NeoHookeanShape.nearly_incompressible(5.0), mesh, vec![], supports);
    let body = bar.mixed().lower().unwrap();
    let solution = Solver::new(&body).unwrap().solve(&[2.0], &Options::default()).unwrap();
    let lateral = STRETCH.powf(-0.5) - 1.0;
    let u = |node: usize, i: usize| solution.displacement[3 * node + i];
    assert!(
        (u(corner, 1) - lateral).abs() < BALANCE_TOLERANCE
            && (u(corner, 2) - lateral).abs() < BALANCE_TOLERANCE
    );
    assert!((u(end, 1) - 0.5 * lateral).abs() < BALANCE_TOLERANCE);
    // Deviatoric stress plus pressure vanish across: p = μ/3 (s² − 1/s)  at J = 1.
    let pressure = 2.0 / 3.0 * (STRETCH * STRETCH - 1.0 / STRETCH);
    for p in &solution.pressure {
        assert!((p - pressure).abs() < 1e-8, "{p} {pressure}");
    }
    assert_eq!(far.len(), 25);
}

fn determinant(f: &Gradient) -> f64 {
    (0..3)
        .map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            f[0][i] * (f[1][j] * f[2][k] - f[1][k] * f[2][j])
        })
        .sum()
}
