//! Bodies that are held too little, too much or in two places at once.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Scene, SceneError, Support};
use sinew_fem::{RigidMode, SolveError, Solver};
use sinew_mesh::{TetMesh, box_tetrahedra};

/// A cube of edge 10 with a node set of all nodes that `chosen` picks, and these supports.
fn held_at(chosen: impl Fn([f64; 3]) -> bool, supports: Vec<Support>) -> Result<Body, SceneError> {
    let mut mesh = box_tetrahedra([10.0; 3], [2; 3]);
    let nodes = (0..mesh.points.len()).filter(|&n| chosen(mesh.points[n])).collect();
    mesh.node_sets.insert("chosen".into(), nodes);
    Scene { supports, ..scene(NeoHookean, mesh) }.lower()
}

#[track_caller]
fn free_modes(potential: &Body) -> Vec<RigidMode> {
    match refusal(potential) {
        SolveError::FreeToMove { modes, .. } => modes,
        other => panic!("{other}"),
    }
}

#[test]
fn an_unclamped_body_is_refused_with_the_axes_it_is_free_along() {
    let error = held_at(|_| false, vec![]).unwrap_err();
    assert_eq!(error, SceneError::Supports("no support holds the body along x, y, z: it is free to move there and has no unique equilibrium; add a support that holds it there".into()));
}

#[test]
fn an_empty_support_leaves_the_body_free() {
    let error = held_at(|_| false, vec![Support::clamped("chosen")]).unwrap_err();
    assert_eq!(error, SceneError::Supports("no support holds the body along x, y, z: it is free to move there and has no unique equilibrium; add a support that holds it there".into()));
}

#[test]
fn a_hinge_leaves_one_rotation_which_is_named() {
    let edge = held_at(|p| p[0] == 0.0 && p[2] == 0.0, vec![Support::clamped("chosen")]).unwrap();
    let modes = free_modes(&edge);
    assert_eq!(modes.len(), 1);
    assert_eq!(modes[0].to_string(), "rotation about y");
}

#[test]
fn a_pinned_point_leaves_three_rotations() {
    let corner = held_at(|p| p == [0.0; 3], vec![Support::clamped("chosen")]).unwrap();
    let modes = free_modes(&corner);
    assert_eq!(modes.len(), 3);
    assert!(modes.iter().all(|m| norm(&m.translation) < 1e-9));
}

#[test]
fn a_slide_leaves_one_translation_which_is_named() {
    let rollers = vec![roller("y_min", 1), roller("z_min", 2), roller("z_max", 2)];
    let error = held_at(|_| false, rollers.clone()).unwrap_err();
    assert_eq!(error, SceneError::Supports("no support holds the body along x: it is free to move there and has no unique equilibrium; add a support that holds it there".into()));
    // Held along x by another slide, at one point: nothing stops the turn about that point.
    let mut supports = rollers;
    supports.remove(0);
    supports.push(Support::clamped("chosen"));
    let modes = free_modes(&held_at(|p| p == [0.0; 3], supports).unwrap());
    // About the z axis through the point, so with a translation of the centre.
    assert_eq!(modes.len(), 1);
    let ([x, y, z], [tx, ty, tz]) = (modes[0].rotation, modes[0].translation);
    assert!(x.abs() < 1e-9 && y.abs() < 1e-9 && tz.abs() < 1e-9 && z.abs() > 0.1);
    assert!((tx + ty).abs() < 1e-9, "perpendicular to the way from the point to the centre");
}

#[test]
fn three_points_on_a_slanted_line_leave_the_turn_about_it() {
    let diagonal = held_at(|[x, y, z]| x == y && y == z, vec![Support::clamped("chosen")]).unwrap();
    let modes = free_modes(&diagonal);
    let [x, y, z] = modes[0].rotation;
    assert_eq!(modes.len(), 1);
    assert!((x - y).abs() < 1e-9 && (y - z).abs() < 1e-9 && x.abs() > 0.5);
}

/// Two cubes that share the edge along y at (x, z) = (1, 1), as a door and its frame.
fn cubes_on_an_edge() -> TetMesh {
    let mut mesh = cube(1);
    let mut index = Vec::new();
    for [x, y, z] in cube(1).points {
        let place = [x + 1.0, y, z + 1.0];
        index.push(mesh.points.iter().position(|&p| p == place).unwrap_or(mesh.points.len()));
        if index.last() == Some(&mesh.points.len()) {
            mesh.points.push(place);
        }
    }
    mesh.cells.extend(cube(1).cells.iter().map(|cell| cell.map(|node| index[node])));
    let top = (0..mesh.points.len()).filter(|&n| mesh.points[n][2] == 2.0).collect();
    mesh.node_sets.insert("top".into(), top);
    mesh
}

#[test]
fn a_part_on_a_shared_edge_turns_about_it_unless_it_is_held() {
    let scene = scene(NeoHookean, cubes_on_an_edge());
    let door = scene.lower().unwrap();
    let modes = free_modes(&door);
    assert_eq!(modes.iter().map(ToString::to_string).collect::<Vec<_>>(), ["rotation about y"]);

    // Held along x at its top it is hinged and yet fixed.
    let latch = Support::uniform("top", [Some(0.1), None, None]);
    let held = Scene { supports: vec![Support::clamped("x_min"), latch], ..scene };
    let held = held.lower().unwrap();
    let solution = solve(&held, &[1.0, 1.0]).unwrap();
    assert_sound(&held, &solution);
}

#[test]
fn three_pins_that_just_suffice_hold_a_body_under_its_weight() {
    let mut mesh = box_tetrahedra([10.0; 3], [2; 3]);
    for (name, place) in [("a", [0.0; 3]), ("b", [10.0, 0.0, 0.0]), ("c", [0.0, 10.0, 0.0])] {
        let node = mesh.points.iter().position(|&p| p == place).unwrap();
        mesh.node_sets.insert(name.into(), vec![node]);
    }
    let held = Some(0.0);
    // Six components, none to spare: 3-2-1.
    let supports = vec![
        Support::clamped("a"),
        Support::uniform("b", [None, held, held]),
        Support::uniform("c", [None, None, held]),
    ];
    let weight = Load::BodyForce([0.0, 0.0, -1e-3]);
    let body = Scene { supports, loads: vec![weight], ..scene(NeoHookean, mesh.clone()) };
    let body = body.lower().unwrap();
    let solution = solve(&body, &[1.0, 1.0]).unwrap();
    assert_sound(&body, &solution);
    // Statically determinate: the three feet carry 1000 · 1e-3 kPa mm², shared as the lever arms of the
    // deformed body say, and nothing pushes sideways.
    let feet = ["a", "b", "c"].map(|f| reaction(&body, &solution, &mesh.node_sets[f]));
    assert_close(feet.iter().map(|f| f[2]).sum(), 1.0, 1e-9);
    assert!(feet.iter().all(|f| f[0].abs() < 1e-9 && f[1].abs() < 1e-9), "{feet:?}");
}

#[test]
fn rollers_on_all_six_sides_leave_rest_or_the_prescribed_box() {
    let mesh = distorted_cube(3);
    let sides = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"];
    let rollers: Vec<_> = sides.iter().enumerate().map(|(i, side)| roller(side, i / 2)).collect();
    let boxed = lower(NeoHookean, mesh.clone(), vec![], rollers.clone());
    let rest = solve(&boxed, &[1.0, 2.0]).unwrap();
    assert!(rest.displacement.iter().all(|&u| u == 0.0));

    let mut supports = rollers;
    supports[1] = Support::uniform("x_max", [Some(-0.3), None, None]);
    let squeezed = lower(NeoHookean, mesh.clone(), vec![], supports);
    let solution = solve(&squeezed, &[1.0, 2.0]).unwrap();
    assert_sound(&squeezed, &solution);
    // Uniaxial strain: u = −0.3 x, ψ = ½λ ln²J − μ ln J + ½μ(J² − 1) with J = 0.7.
    let exact: Vec<_> = mesh.points.iter().flat_map(|p| [-0.3 * p[0], 0.0, 0.0]).collect();
    assert!(difference(&solution.displacement, &exact) < 1e-10);
    let log = 0.7_f64.ln();
    assert_close(solution.energy, log * log - log + 0.5 * (0.49 - 1.0), 1e-12);
}

#[test]
fn a_body_with_all_nodes_prescribed_is_what_is_prescribed() {
    let mut mesh = cube(2);
    mesh.node_sets.insert("all".into(), (0..mesh.points.len()).collect());
    let shear = |[_, y, _]: [f64; 3]| [0.4 * y, 0.0, 0.0];
    let supports = vec![Support::moved("all", &mesh, shear)];
    let body = lower(NeoHookean, mesh.clone(), vec![], supports);
    let mut solver = Solver::new(&body).unwrap();
    assert_eq!(solver.unknowns(), 0);
    let solution = solver.solve(&[3.0, 1.0], &Default::default()).unwrap();
    let exact: Vec<_> = mesh.points.iter().flat_map(|&p| shear(p)).collect();
    assert_eq!(solution.displacement, exact);
    // Simple shear: ψ = ½ μ γ².
    assert_close(solution.energy, 0.5 * 3.0 * 0.16, 1e-13);
    // What else the solver does has nothing to do.
    let columns = solver.sensitivity(&solution).unwrap();
    assert!(columns.iter().flatten().all(|&c| c == 0.0));
    assert!(solver.stiffness(&solution).unwrap().values.is_empty());
}

#[test]
fn all_nodes_prescribed_into_an_inverted_cell_are_refused() {
    let mut mesh = cube(1);
    mesh.node_sets.insert("all".into(), (0..8).collect());
    let supports = vec![Support::moved("all", &mesh, |[x, _, _]| [-2.0 * x, 0.0, 0.0])];
    let failure = failure(solve(&lower(NeoHookean, mesh, vec![], supports), &[1.0, 1.0]));
    // The cube is flat at half the motion.
    assert!(failure.load_factor > 0.45 && failure.load_factor < 0.5, "{}", failure.load_factor);
}

#[test]
fn contradictory_supports_are_refused_with_both_values() {
    let supports =
        vec![Support::clamped("x_min"), Support::uniform("y_min", [Some(0.25), None, None])];
    let error = held_at(|_| false, supports).unwrap_err();
    let expected = SceneError::Supports(
        "the support of `y_min` prescribes 0.25 along (1, 0, 0) for node 0, but it is held at 0 there by those of x_min; take the node out of one of the sets, or let the supports agree".into(),
    );
    assert_eq!(error, expected);
    for [first, second] in [[0.1, 1000.0], [1e-20, 1.0], [1e308, -1e308]] {
        let of = |set, u| Support::uniform(set, [Some(u); 3]);
        let error = held_at(|_| false, vec![of("x_min", first), of("y_min", second)]).unwrap_err();
        assert!(error.to_string().contains(&format!("held at {first} there")), "{error}");
    }
}

#[test]
fn supports_that_agree_where_they_meet_are_kept() {
    let supports = vec![Support::clamped("x_min"), Support::clamped("y_min")];
    assert!(Solver::new(&held_at(|_| false, supports).unwrap()).is_ok());
}

#[test]
fn an_unknown_node_set_is_refused_with_those_that_exist() {
    let error = held_at(|_| false, vec![Support::clamped("x_mni")]).unwrap_err();
    let text = error.to_string();
    let known = text.strip_prefix("there is no node set `x_mni`; the mesh has ");
    assert_eq!(known.expect("those that exist").split(", ").count(), 7);
    // A motion of an unknown set is reported too, not taken for an empty one.
    let moved = Support::moved("x_mni", &TetMesh::default(), |x| x);
    let error = held_at(|_| false, vec![moved]).unwrap_err().to_string();
    assert!(error.contains("there is no node set `x_mni`"), "{error}");
}

#[test]
fn prescribed_motions_that_are_no_numbers_are_refused() {
    for motion in [f64::NAN, f64::INFINITY] {
        let supports = vec![Support::uniform("x_min", [Some(motion), Some(0.0), Some(0.0)])];
        let error = held_at(|_| false, supports).unwrap_err();
        let SceneError::NotFinite { what, value } = error else { panic!("{error}") };
        assert!(what.contains("x_min") && !value.is_finite());
    }
}

#[test]
fn a_prescribed_motion_beyond_all_bounds_is_refused() {
    for motion in [1e10, 1e200, f64::MAX] {
        let supports =
            vec![Support::clamped("x_min"), Support::uniform("x_max", [Some(-motion); 3])];
        let body = held_at(|_| false, supports).unwrap();
        let failure = failure(solve(&body, &[1.0, 1.0]));
        assert!(failure.load_factor < 1e-3);
    }
}

#[test]
fn a_list_of_motions_of_the_wrong_length_is_refused() {
    let mesh = cube(3);
    let supports = vec![Support::moved("x_min", &mesh, |_| [0.0; 3])];
    let error = held_at(|_| false, supports).unwrap_err();
    let expected = SceneError::Supports(
        "the support of node set `x_min` lists 16 displacements for 9 nodes; give one per node"
            .into(),
    );
    assert_eq!(error, expected);
}
