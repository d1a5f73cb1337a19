//! Descent with a frozen stiffness for many parameter sets, where bodies are hard.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::{Guccione, NeoHookean};
use sinew_energy::{Body, Load, Scene, Support};
use sinew_fem::{FrozenStiffness, Options, SolveError, Solver, Stop};
use sinew_mesh::box_tetrahedra;

/// Steps that a solve by Newton's method is worth.
const MANY: usize = 60;

fn held_at<'b>(body: &'b Body, theta: &[f64]) -> FrozenStiffness<'b> {
    let mut solver = Solver::new(body).unwrap();
    let known = solver.solve(theta, &Options::default()).unwrap().displacement;
    solver.frozen_stiffness(&known, theta).unwrap()
}

fn beam(load: f64) -> Body {
    let beam = scene(NeoHookean, box_tetrahedra([10.0, 1.0, 1.0], [10, 2, 2]));
    Scene { loads: vec![Load::BodyForce([0.0, 0.0, load])], ..beam }.lower().unwrap()
}

/// A beam that bends far, from the stiffness of one ten times as stiff, or a hundred times as soft.
#[test]
fn stiffness_of_another_size_leads_to_equilibrium() {
    let body = beam(-0.01);
    let held = held_at(&body, &[100.0, 100.0]);
    for theta in [[20.0, 20.0], [10.0, 100.0], [1e4, 1e4]] {
        let exact = solve(&body, &theta).unwrap();
        let found = held.refine(&body, &held.displacement, &theta, Stop::after(MANY)).unwrap();
        println!(
            "{theta:?} {} {:e} {:e}",
            found.steps, found.residual_before, found.residual_after
        );
        assert!(
            found.residual_after < 1e-6 * found.residual_before,
            "{theta:?}: {:e} {:e}",
            found.residual_before,
            found.residual_after
        );
        assert_close(found.energy, exact.energy, 1e-9);
    }
}

/// The inverted cell is the one that is named, not the worst of a state that was assembled before.
#[test]
fn steps_from_an_inverted_cell_name_it() {
    let body = beam(-0.01);
    let held = held_at(&body, &[2.0, 2.0]);
    let mut solver = Solver::new(&body).unwrap();
    let rest = vec![0.0; held.displacement.len()];
    solver.newton_steps(&rest, &[2.0, 2.0], 1).unwrap();
    for cell in [17, 101] {
        // A cell's last node goes to the other side of the three others.
        let nodes = body.nodes_of_cell(cell);
        let mut turned = rest.clone();
        for i in 0..3 {
            let middle = nodes[..3].iter().map(|&node| body.positions[node][i]).sum::<f64>() / 3.0;
            turned[3 * nodes[3] + i] = 3.0 * (middle - body.positions[nodes[3]][i]);
        }
        let ratio = |cell: usize| body.displacement_gradient(cell, &turned).volume_change();
        let worst = (0..body.cell_count()).min_by(|&a, &b| ratio(a).total_cmp(&ratio(b))).unwrap();
        let expected = SolveError::Inadmissible { cell: worst };
        let theta = [2.0, 2.0];
        assert_eq!(solver.simplified_step(&turned, &theta).unwrap_err(), expected);
        assert_eq!(held.refine(&body, &turned, &theta, Stop::after(3)).unwrap_err(), expected);
    }
}

/// Energies never rise, and nothing that is balanced is moved.
#[test]
fn an_equilibrium_is_left_as_it_is() {
    let body = beam(-0.01);
    let held = held_at(&body, &[2.0, 2.0]);
    let found = held.refine(&body, &held.displacement, &[2.0, 2.0], Stop::after(MANY)).unwrap();
    let moved = found.displacement.iter().zip(&held.displacement).map(|(a, b)| (a - b).abs());
    assert!(moved.fold(0.0, f64::max) < 1e-10);
    let energies = (0..8).map(|steps| {
        held.refine(&body, &held.displacement, &[1.0, 3.0], Stop::after(steps)).unwrap()
    });
    let energies: Vec<f64> = energies.map(|found| found.energy).collect();
    assert!(energies.windows(2).all(|pair| pair[1] <= pair[0]), "{energies:?}");
}

/// A residual that is asked for ends the steps, and so does their number.
#[test]
fn steps_end_at_the_first_bound() {
    let body = beam(-0.01);
    let held = held_at(&body, &[2.0, 2.0]);
    let after =
        |mu: f64, stop: Stop| held.refine(&body, &held.displacement, &[mu, 3.0], stop).unwrap();
    let whole = after(1.0, Stop::after(MANY));
    let rough = after(1.0, Stop { residual: 1e-3, ..Stop::after(MANY) });
    assert!(rough.unbalanced() <= 1e-3 && rough.unbalanced() > 10.0 * whole.unbalanced());
    assert!(rough.steps < whole.steps && whole.error.is_none());
    assert_eq!(after(1.0, Stop::after(rough.steps)).displacement, rough.displacement);
    let within = after(1.9, Stop::within(1e-4, MANY));
    assert!(within.error.is_some_and(|error| error <= 1e-4), "{within:?}");
    assert_eq!(after(1.9, Stop::within(1e-4, within.steps)).error, None);
    assert_eq!(after(1.0, Stop::within(1e-4, MANY)).error, None); // too far
}

/// Supports along turned axes, with motions that are prescribed, stay where they are.
#[test]
fn prescribed_motions_in_turned_frames_are_kept() {
    let supports = vec![Support::clamped("x_min"), Support::along("x_max", [0.6, 0.0, 0.8], 0.5)];
    let body = Scene { supports, ..scene(NeoHookean, cube(3)) }.lower().unwrap();
    let held = held_at(&body, &[1.0, 1.0]);
    let exact = solve(&body, &[3.0, 0.5]).unwrap();
    let found =
        held.refine(&body, &vec![0.0; 3 * body.nodes], &[3.0, 0.5], Stop::after(MANY)).unwrap();
    let off = found.displacement.iter().zip(&exact.displacement).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-7);
}

/// A descent from where exponentials are near overflow ends with less energy, or where it began: never in between with a NaN.
#[test]
fn descents_near_overflow_have_numbers() {
    let frame = Guccione::frame([1.0, 0.0, 0.0]);
    let bar = with_directions(Guccione.nearly_incompressible(100.0), cube(3), frame);
    let loads = vec![traction("x_max", [30.0, 0.0, 0.0])];
    let body = Scene { loads, supports: corner_rollers(), ..bar }.lower().unwrap();
    let held = held_at(&body, &[2.0, 8.0, 2.0, 4.0]);
    for factor in [2.0, 10.0, 50.0, 1e3] {
        let stiff = [2.0, 8.0 * factor, 2.0 * factor, 4.0 * factor];
        match held.refine(&body, &held.displacement, &stiff, Stop::after(MANY)) {
            Ok(found) => {
                println!("{factor}: {} steps, {:e}", found.steps, found.residual_after);
                let before = body.value(&held.displacement, &stiff);
                assert!(found.energy <= before && found.residual_after.is_finite());
                assert!(factor > 2.0 || found.residual_after < 1e-6 * found.residual_before);
            }
            Err(error) => assert!(matches!(error, SolveError::Inadmissible { .. }), "{error}"),
        }
    }
}

#[test]
fn a_start_that_turns_a_cell_over_is_refused_with_the_cell() {
    let body = beam(-0.01);
    let held = held_at(&body, &[2.0, 2.0]);
    let mut turned = vec![0.0; 3 * body.nodes];
    let node = (0..body.nodes).find(|&node| body.positions[node] == [5.0, 0.5, 0.5]).unwrap();
    turned[3 * node] = -3.0;
    let Err(SolveError::Inadmissible { cell }) =
        held.refine(&body, &turned, &[2.0, 2.0], Stop::after(3))
    else {
        panic!("an inverted cell has no energy");
    };
    assert!(body.cell_nodes().nth(cell).unwrap().contains(&node));
    assert!(held.refine(&body, &[0.0], &[2.0, 2.0], Stop::after(3)).is_err());
    assert!(held.refine(&body, &held.displacement, &[2.0], Stop::after(3)).is_err());
    let solver = Solver::new(&body).unwrap();
    assert!(solver.frozen_stiffness(&turned, &[2.0, 2.0]).is_err());
}

/// The stiffness of one shape leads to the equilibrium of another, with a scar that it does not know; a body of other cells or supports is
/// refused.
#[test]
fn the_stiffness_of_another_body_leads_to_equilibrium_or_is_refused() {
    let shaped = |wave: f64, supports: Vec<Support>| {
        let mut mesh = box_tetrahedra([4.0, 1.0, 1.0], [8, 2, 2]);
        mesh.map_points(|[x, y, z]| [x, y, z * (1.0 + wave * (2.0 * x).sin())]);
        let loads = vec![Load::BodyForce([0.0, 0.0, -0.01])];
        Scene { loads, supports, ..scene(NeoHookean, mesh) }.lower().unwrap()
    };
    let clamped = || vec![Support::clamped("x_min")];
    let (known, met) = (shaped(0.0, clamped()), shaped(0.3, clamped()));
    let factors = (0..met.nodes).map(|node| if node % 7 < 2 { 8.0 } else { 1.0 });
    let met = met.stiffened(&factors.collect::<Vec<_>>()).unwrap();
    let held = held_at(&known, &[2.0, 2.0]);
    let exact = solve(&met, &[1.0, 4.0]).unwrap();
    let found = held.refine(&met, &held.displacement, &[1.0, 4.0], Stop::after(MANY)).unwrap();
    assert_close(found.energy, exact.energy, 1e-9);
    let refused =
        |body: &Body| match held.refine(body, &held.displacement, &[1.0, 4.0], Stop::after(3)) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("another body"),
        };
    assert!(refused(&beam(-0.01)).contains("nodes"));
    assert!(refused(&shaped(0.1, vec![Support::clamped("x_max")])).contains("held components"));
}

/// A nearly incompressible body of another shape is out of reach, and the residual says so although the residual has become
/// a hundred times smaller; the same body with a softer volume is reached.
#[test]
fn a_descent_that_arrives_nowhere_says_so() {
    for (bulk_modulus, reached) in [(20.0, true), (1e5, false)] {
        let shaped = |wave: f64| {
            let mut mesh = box_tetrahedra([3.0, 1.0, 1.0], [6, 2, 2]);
            mesh.map_points(|[x, y, z]| [x, y * (1.0 - wave * x.sin()), z + wave * x]);
            let law = Guccione.nearly_incompressible(bulk_modulus);
            let bar = with_directions(law, mesh, Guccione::frame([1.0, 0.0, 0.0]));
            let loads = vec![Load::BodyForce([0.0, 0.0, -0.02])];
            let supports = vec![Support::clamped("x_min")];
            Scene { loads, supports, ..bar }.lower().unwrap()
        };
        let (known, met) = (shaped(0.0), shaped(0.1));
        let (at, theta) = ([2.0, 8.0, 2.0, 4.0], [1.0, 8.0, 2.0, 4.0]);
        let held = held_at(&known, &at);
        let exact = solve(&met, &theta).unwrap().displacement;
        let found = held.refine(&met, &held.displacement, &theta, Stop::after(32)).unwrap();
        let size = exact.iter().map(|u| u * u).sum::<f64>().sqrt();
        let off = found.displacement.iter().zip(&exact).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        let (off, left) = (off.sqrt() / size, found.unbalanced());
        println!(
            "{bulk_modulus}: {off:.1e} off, {left:.1e} unbalanced, residual {:.1e}",
            found.residual_after / found.residual_before
        );
        assert_eq!(off < 0.02, reached);
        assert_eq!(left < 0.01, reached);
    }
}

/// Supports whose directions are turned with the shape: radial ones about a tilted axis, where each node has a frame of its own, and a
/// slope of another angle. Directions across to those held are none of them.
#[test]
fn supports_that_turn_with_the_shape_are_followed() {
    let shaped = |tilt: f64, slope: f64| {
        let (sin, cos) = tilt.sin_cos();
        let mut mesh = box_tetrahedra([4.0, 4.0, 6.0], [3, 3, 4]);
        mesh.map_points(|[x, y, z]| [x, cos * y - sin * z, sin * y + cos * z]);
        let supports = vec![
            Support::radial("z_min", [2.0, 2.0 * cos, 2.0 * sin], [0.0, -sin, cos]),
            Support::along("z_max", [0.0, slope.sin(), slope.cos()], 0.1),
        ];
        let loads = vec![Load::BodyForce([0.02, 0.03, -0.05])];
        Scene { loads, supports, ..scene(NeoHookean, mesh) }.lower().unwrap()
    };
    let (known, met) = (shaped(0.0, 0.0), shaped(0.5, 0.4));
    assert_ne!(
        known.prescribed.iter().map(Option::is_some).collect::<Vec<_>>(),
        met.prescribed.iter().map(Option::is_some).collect::<Vec<_>>(),
        "the hard part"
    );
    let held = held_at(&known, &[2.0, 2.0]);
    let exact = solve(&met, &[1.0, 4.0]).unwrap();
    let found = held.refine(&met, &held.displacement, &[1.0, 4.0], Stop::after(MANY)).unwrap();
    let off = found.displacement.iter().zip(&exact.displacement).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f64::max) < 1e-6);
    let across = shaped(0.0, std::f64::consts::FRAC_PI_2);
    let refused =
        held.refine(&across, &held.displacement, &[1.0, 4.0], Stop::after(MANY)).unwrap_err();
    assert!(refused.to_string().contains("directions of supports"), "{refused}");
}
