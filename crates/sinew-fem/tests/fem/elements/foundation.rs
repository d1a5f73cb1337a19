//! Elastic foundations against closed forms.

use crate::distort::Distort as _;
use crate::elements::scene::{distance, node_at, roller, scene, with_boundary};
use sinew_energy::laws::{LinearElastic, NeoHookean};
use sinew_energy::{Load, Magnitude};
use sinew_fem::{Options, Solver};
use sinew_mesh::{AnyMesh, QuadraticTetMesh, box_hexahedra, box_tetrahedra, rectangle_triangles};

/// A bar of length 2 pulled at one end and held by springs at the other: `u = t/k + t x/E`, exactly, as long
/// as it does not contract (λ = 0, so E = 2μ).
fn check_bar(mesh: impl Into<AnyMesh>, rollers: &[(&str, usize)]) {
    const TRACTION: f64 = 0.3;
    const SPRING: f64 = 0.5;
    const SHEAR: f64 = 1.5;
    let loads = vec![
        Load::Traction { facets: "x_max".into(), value: [TRACTION, 0.0, 0.0] },
        Load::Foundation { facets: "x_min".into(), normal: SPRING, tangential: 0.0 },
    ];
    let supports = rollers.iter().map(|(set, axis)| roller(set, *axis)).collect();
    let scene = scene(LinearElastic, mesh, loads, supports);
    let body = scene.lower().unwrap();
    let solution = Solver::new(&body).unwrap().solve(&[SHEAR, 0.0], &Options::default()).unwrap();
    let exact = |x: &[f64; 3]| [TRACTION / SPRING + TRACTION * x[0] / (2.0 * SHEAR), 0.0, 0.0];
    let exact: Vec<f64> = scene.mesh.points().iter().flat_map(exact).collect();
    let error = distance(&solution.displacement, &exact);
    assert!(error < 1e-10, "{}: {error:e}", scene.mesh.element().plural);
}

#[test]
fn a_bar_on_springs_at_its_end() {
    let rollers = [("y_min", 1), ("z_min", 2)];
    let extent = [2.0, 1.0, 1.0];
    check_bar(box_tetrahedra(extent, [3, 2, 2]).distorted(5, 0.3), &rollers);
    check_bar(box_tetrahedra(extent, [2, 1, 2]).distorted(5, 0.3).quadratic(), &rollers);
    check_bar(box_hexahedra(extent, [3, 2, 2]).distorted(5, 0.3), &rollers);
    check_bar(rectangle_triangles([2.0, 1.0], [3, 2]).distorted(5, 0.3), &rollers[..1]);
    check_bar(rectangle_triangles([2.0, 1.0], [3, 2]).quadratic(), &rollers[..1]);
}

/// A stiff block on springs k at one end under its own weight f: the springs shear by `f L/k_t` and turn by `θ = M/(k I)`, `M = f A L²/2`, on any mesh.
fn check_turn(mesh: impl Into<AnyMesh>, down: usize) {
    const LENGTH: f64 = 2.0;
    const HEIGHT: f64 = 1.0;
    const NORMAL: f64 = 0.5;
    const TANGENTIAL: f64 = 0.7;
    const WEIGHT: f64 = 1e-3;
    let mut force = [0.0; 3];
    force[down] = WEIGHT;
    let loads = vec![
        Load::BodyForce(force),
        Load::Foundation { facets: "x_min".into(), normal: NORMAL, tangential: TANGENTIAL },
    ];
    let scene = scene(LinearElastic, mesh, loads, vec![]);
    let body = scene.lower().unwrap();
    let solution = Solver::new(&body).unwrap().solve(&[1e5, 0.0], &Options::default()).unwrap();
    let turn = 0.5 * WEIGHT * LENGTH.powi(2) / (NORMAL * HEIGHT.powi(2) / 12.0);
    let exact = |x: &[f64; 3]| {
        let mut u = [0.0; 3];
        u[0] = -turn * (x[down] - 0.5 * HEIGHT);
        u[down] = WEIGHT * LENGTH / TANGENTIAL + turn * x[0];
        u
    };
    let exact: Vec<f64> = scene.mesh.points().iter().flat_map(exact).collect();
    let error = distance(&solution.displacement, &exact);
    assert!(error < 1e-6, "{}: {error:e}", scene.mesh.element().plural);
}

#[test]
fn springs_answer_a_turn_of_their_face() {
    let extent = [2.0, 1.0, 1.0];
    check_turn(box_tetrahedra(extent, [2, 1, 1]), 2);
    check_turn(box_tetrahedra(extent, [3, 2, 2]).distorted(5, 0.3), 2);
    check_turn(box_tetrahedra(extent, [2, 1, 1]).quadratic(), 2);
    check_turn(box_hexahedra(extent, [2, 1, 2]), 2);
    check_turn(rectangle_triangles([2.0, 1.0], [3, 2]), 1);
    check_turn(rectangle_triangles([2.0, 1.0], [3, 2]).quadratic(), 1);
}

/// A thin bar that sticks to an elastic layer along its side: `E h u'' = k u`, so with a traction t at the end
/// `u = (t ℓ/E) cosh(x/ℓ)/sinh(L/ℓ)` and `ℓ² = E h/k`.
#[test]
fn a_bar_on_springs_along_its_side() {
    const LENGTH: f64 = 2.0;
    const HEIGHT: f64 = 0.01;
    const YOUNG: f64 = 3.0;
    const DECAY: f64 = 0.8;
    const TRACTION: f64 = 0.01;
    let mesh = rectangle_triangles([LENGTH, HEIGHT], [40, 1]).quadratic();
    let stiffness = YOUNG * HEIGHT / (DECAY * DECAY);
    let loads = vec![
        Load::Traction { facets: "x_max".into(), value: [TRACTION, 0.0, 0.0] },
        Load::Foundation { facets: "y_min".into(), normal: 0.0, tangential: stiffness },
    ];
    let scene = scene(LinearElastic, mesh, loads, vec![roller("y_min", 1)]);
    let body = scene.lower().unwrap();
    let solution =
        Solver::new(&body).unwrap().solve(&[0.5 * YOUNG, 0.0], &Options::default()).unwrap();
    for x in [0.0, 0.5, 1.0, 1.5, LENGTH] {
        let node = node_at(scene.mesh.points(), [x, 0.5 * HEIGHT, 0.0]);
        let exact = TRACTION * DECAY / YOUNG * (x / DECAY).cosh() / (LENGTH / DECAY).sinh();
        // The shear in the bar is neglected: k h/μ = 3e-4 here.
        let found = solution.displacement[3 * node];
        assert!((found / exact - 1.0).abs() < 3e-4, "{x}: {found} {exact}");
    }
}

/// A body that nothing but springs hold, under a pressure on a loose rim: turned as a whole, it does the same.
#[test]
fn a_sprung_body_knows_no_axes() {
    // A rotation with rational entries, off all axes.
    const TURN: [[f64; 3]; 3] = [
        [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0],
        [2.0 / 3.0, 2.0 / 3.0, -1.0 / 3.0],
        [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0],
    ];
    let turned = |x: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|j| TURN[i][j] * x[j]).sum())
    };
    let solve = |mesh: QuadraticTetMesh, force: [f64; 3]| {
        let loads = vec![
            Load::BodyForce(force),
            Load::Foundation { facets: "boundary".into(), normal: 0.5, tangential: 0.1 },
            Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Fixed(0.3) },
        ];
        let scene = scene(NeoHookean, with_boundary(mesh), loads, vec![]);
        let body = scene.loose_rims().lower().unwrap();
        assert_eq!(body.followers.len(), 1);
        let solution = Solver::new(&body).unwrap().solve(&[1.0, 2.0], &Options::default()).unwrap();
        assert!(solution.residual < 1e-9 * solution.force_scale);
        solution.displacement
    };
    let straight = box_tetrahedra([2.0, 1.0, 0.5], [4, 2, 1]).quadratic();
    let force = [0.05, 0.1, -0.1];
    let first = solve(straight.clone(), force);
    let size = first.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
    assert!(size > 0.1, "the displacement is large: {size}");
    let mut oblique = straight;
    oblique.map_points(turned);
    let second = solve(oblique, turned(force));
    let expected: Vec<f64> = first.as_chunks::<3>().0.iter().flat_map(|&u| turned(u)).collect();
    let error = distance(&second, &expected);
    assert!(error < 1e-8 * size, "{error:e} of {size}");
}
