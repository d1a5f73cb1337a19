//! Error estimates of displacements that are far from any equilibrium, or near another one than is asked for.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::{Guccione, NeoHookean};
use sinew_energy::metrics::displacement_error;
use sinew_energy::{Body, Load, Magnitude, Scene, Support};
use sinew_fem::{ErrorEstimate, NotNearEquilibrium, Options, SolveError, Solver, Stop};
use sinew_mesh::box_tetrahedra;

fn estimate(body: &Body, guess: &[f64], theta: &[f64]) -> ErrorEstimate {
    Solver::new(body).unwrap().error_estimate(guess, theta).unwrap()
}

fn mean(a: &[f64], b: &[f64]) -> f64 {
    let nodal = displacement_error(a, b);
    nodal.iter().sum::<f64>() / nodal.len() as f64
}

/// No number, or one that is at least half of the true mean distance; the number.
#[track_caller]
fn assert_true_or_absent(body: &Body, guess: &[f64], theta: &[f64]) -> Option<f64> {
    let truth = solve(body, theta).unwrap().displacement;
    let found = estimate(body, guess, theta);
    match found.distance {
        Ok(distance) => {
            let ratio = mean(guess, &truth) / distance.mean;
            println!(
                "{theta:?}: true over estimated {ratio:.3}, contraction {:.1e}",
                distance.contraction
            );
            assert!(ratio <= 2.0, "{theta:?}: {ratio}");
            Some(distance.mean)
        }
        Err(reason) => {
            println!("{theta:?}: {reason}");
            None
        }
    }
}

/// The error that an iteration leaves, of a solve that ends early, beside the distance to one that goes on.
#[test]
fn the_error_of_an_iteration_that_ends_early_is_known() {
    let gravity = Load::BodyForce([0.0, 0.0, -9.8e-3]); // kPa/mm
    let beam = scene(NeoHookean, box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]));
    let body = beam.load(gravity).lower().unwrap();
    let theta = [20.0, 40.0];
    let solved = |minimum_accuracy: f64| {
        let options = Options { minimum_accuracy, ..Options::default() };
        Solver::new(&body).unwrap().solve(&theta, &options).unwrap()
    };
    let exact = solved(Options::default().minimum_accuracy);
    for minimum_accuracy in [1e-2, 1e-5] {
        let early = solved(minimum_accuracy);
        let error = mean(&early.displacement, &exact.displacement);
        let estimate = early.iteration_error.unwrap();
        println!("{minimum_accuracy:e}: error {error:.2e}, estimate {estimate:.2e}");
        assert!(early.residual > exact.residual && (estimate / error - 1.0).abs() < 0.1);
    }
    assert!(exact.iteration_error.unwrap() < 1e-10, "{:?}", exact.iteration_error); // mm
}

/// An exponential law that is stretched too far: each Newton step is short there, although the error is large.
#[test]
fn a_short_newton_step_in_a_stiffening_law_is_no_small_error() {
    let pulled_by = |load: f64| {
        let bar = with_directions(
            Guccione.nearly_incompressible(50.0),
            box_tetrahedra([3.0, 1.0, 1.0], [6, 2, 2]),
            Guccione::frame([1.0, 0.0, 0.0]),
        );
        Scene { loads: vec![traction("x_max", [load, 0.0, 0.0])], ..bar }.lower().unwrap()
    };
    let theta = [2.0, 30.0, 10.0, 10.0];
    let body = pulled_by(5.0);
    let truth = solve(&body, &theta).unwrap().displacement;
    // The equilibrium of two thousand times the load, far beyond.
    let guess = solve(&pulled_by(1e4), &theta).unwrap().displacement;
    let mut solver = Solver::new(&body).unwrap();
    let step = solver.newton_steps(&guess, &theta, 1).unwrap().remove(0);
    let of_step = mean(&step.displacement, &guess) / step.length.max(f64::MIN_POSITIVE);
    let found = estimate(&body, &guess, &theta);
    println!(
        "one step {of_step:e} for {:e}; {:?}",
        mean(&guess, &truth),
        found.distance.as_ref().err()
    );
    assert!(of_step < 0.5 * mean(&guess, &truth), "one step understates by more than two");
    assert!(found.residual > 0.1, "{}", found.residual);
    assert_true_or_absent(&body, &guess, &theta);
    // Two per cent off there is a number, and it is true.
    let near: Vec<f64> = truth.iter().map(|u| 1.02 * u).collect();
    let number = assert_true_or_absent(&body, &near, &theta).expect("an equilibrium is near");
    assert!((number / mean(&near, &truth) - 1.0).abs() < 0.1);
}

/// Beyond the largest pressure that a box of rubber bears there is no equilibrium, however long steps lower the energy.
#[test]
fn a_pressure_beyond_the_limit_point_has_no_estimate() {
    let walls = box_tetrahedra([4.0, 4.0, 0.2], [8, 8, 1]);
    let supports = ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped).to_vec();
    let load = Load::Pressure { facets: "z_min".into(), magnitude: Magnitude::Theta(2) };
    let mut membrane = scene(NeoHookean, walls);
    membrane.parameters = sinew_energy_parameters();
    let body = Scene { supports, loads: vec![load], ..membrane }.lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let bears = [1.0, 5.0, 0.05];
    let known = solver.solve(&bears, &Options::default()).unwrap().displacement;
    let held = solver.frozen_stiffness(&known, &bears).unwrap();
    let beyond = [1.0, 5.0, 2.0];
    assert!(solver.solve(&beyond, &Options::default()).is_err(), "there is no equilibrium");
    for steps in [0, 4, 200] {
        let moved = held.refine(&body, &known, &beyond, Stop::after(steps)).unwrap();
        let found = estimate(&body, &moved.displacement, &beyond);
        let reason = found.distance.expect_err("no equilibrium is near");
        println!("after {steps} steps: {reason}");
        assert!(reason.to_string().starts_with("not near a"), "{reason}");
    }
    // Within what it bears, the same guess has a number.
    let within = [1.0, 5.0, 0.06];
    assert!(assert_true_or_absent(&body, &known, &within).is_some());
}

fn sinew_energy_parameters() -> Vec<sinew_energy::Parameter> {
    ["mu", "lambda", "p"]
        .map(|name| sinew_energy::Parameter::log(name, "kPa", 1e-3..=10.0))
        .to_vec()
}

/// A soft beam that rolls up: stresses along it are corrected by the first step, the bending by later ones.
#[test]
fn slender_bodies_that_turn_far_have_true_estimates_or_none() {
    let beam = scene(NeoHookean, box_tetrahedra([10.0, 1.0, 1.0], [12, 2, 2]));
    let body = Scene { loads: vec![Load::BodyForce([0.0, 0.0, -0.02])], ..beam }.lower().unwrap();
    let mut solver = Solver::new(&body).unwrap();
    let centre = [60.0, 120.0];
    let known = solver.solve(&centre, &Options::default()).unwrap().displacement;
    let slopes = solver.sensitivity_at(&known, &centre).unwrap();
    let (mut estimated, mut understated_by_one_step) = (0, 0);
    for mu in [10.0, 15.0, 25.0, 40.0, 55.0, 90.0, 200.0] {
        // First order in the logarithm of the stiffness, as far as it turns no cell over.
        for part in [1.0, 0.5, 0.2] {
            let by_log = part * f64::ln(mu / centre[0]) * centre[0];
            let guess: Vec<f64> =
                known.iter().zip(&slopes[0]).map(|(u, slope)| u + by_log * slope).collect();
            let theta = [mu, 120.0];
            let Ok(step) = solver.newton_steps(&guess, &theta, 1) else { continue };
            let step = &step[0];
            let truth = solver.solve(&theta, &Options::default()).unwrap().displacement;
            let one_step = mean(&step.displacement, &guess) / step.length.max(f64::MIN_POSITIVE);
            understated_by_one_step += usize::from(mean(&guess, &truth) > 2.0 * one_step);
            estimated += usize::from(assert_true_or_absent(&body, &guess, &theta).is_some());
        }
    }
    println!("{estimated} estimated, {understated_by_one_step} understated by one step");
    assert!(estimated >= 5 && understated_by_one_step > 0);
}

/// A shallow arch that has snapped through rests in an equilibrium of its own, above the energy of the arch at rest.
#[test]
fn an_equilibrium_of_another_branch_is_named() {
    let mut mesh = box_tetrahedra([20.0, 1.0, 0.25], [40, 1, 2]);
    for point in &mut mesh.points {
        point[2] += 1.5 * (std::f64::consts::PI * point[0] / 20.0).sin();
    }
    let feet = |p: [f64; 3]| (p[0] == 0.0 || p[0] == 20.0) && p[2].abs() < 1e-9;
    let feet = (0..mesh.points.len()).filter(|&n| feet(mesh.points[n])).collect();
    mesh.node_sets.insert("feet".into(), feet);
    let arch = |weight: f64| {
        let supports = vec![Support::clamped("feet")];
        let loads = vec![Load::BodyForce([0.0, 0.0, weight])];
        Scene { supports, loads, ..scene(NeoHookean, mesh.clone()) }.lower().unwrap()
    };
    let theta = [1.0, 1.0];
    let snapped = solve(&arch(-0.02), &theta).unwrap().displacement;
    // Under a thousandth of the weight it stays where it is.
    let light = arch(-2e-5);
    let mut solver = Solver::new(&light).unwrap();
    let stays = solver.solve_from(&snapped, &theta, &Options::default()).unwrap();
    let from_rest = solver.solve(&theta, &Options::default()).unwrap();
    assert!(stays.is_stable() && stays.energy > 0.0 && from_rest.energy < 0.0);
    let found = estimate(&light, &stays.displacement, &theta);
    assert!(
        matches!(found.distance, Err(NotNearEquilibrium::AboveRest { .. })),
        "{:?}",
        found.distance
    );
    let distance = estimate(&light, &from_rest.displacement, &theta).distance.unwrap();
    assert!(distance.mean < 1e-9, "{distance:?}");
}

/// The residual of a descent is relative to the forces of its own body, not to those of the body of the frozen stiffness.
#[test]
fn unbalanced_forces_are_relative_to_the_own_ones() {
    let block = |size: f64| {
        let mesh = box_tetrahedra([3.0 * size, size, size], [6, 2, 2]);
        Scene { loads: vec![Load::BodyForce([0.0, 0.0, -1.0 / size])], ..scene(NeoHookean, mesh) }
            .lower()
            .unwrap()
    };
    let (large, small, theta) = (block(1.0), block(1e-3), [50.0, 50.0]);
    let mut solver = Solver::new(&large).unwrap();
    let known = solver.solve(&theta, &Options::default()).unwrap().displacement;
    let held = solver.frozen_stiffness(&known, &theta).unwrap();
    let truth = solve(&small, &theta).unwrap().displacement;
    let rest = vec![0.0; truth.len()];
    let found = held.refine(&small, &rest, &theta, Stop::after(1)).unwrap();
    let off = mean(&found.displacement, &truth) / mean(&rest, &truth);
    println!("{off:.2} off, {:.1e} unbalanced", found.unbalanced());
    assert!(off > 0.05 && found.unbalanced() > 0.02);
    // The solution of the large body inverts cells of the small one, until it is shortened.
    let whole = held.refine(&small, &known, &theta, Stop::after(40));
    assert!(matches!(whole, Err(SolveError::Inadmissible { .. })));
    let shortened = held.descend(&small, &theta, 40).unwrap();
    assert!(mean(&shortened.displacement, &truth) < 1e-6 * mean(&rest, &truth));
    // By the body itself.
    let mut gradient = vec![0.0; truth.len()];
    small.value_and_gradient(&found.displacement, &theta, &mut gradient);
    let norm_of = |held: bool| {
        let own = small.prescribed.iter().zip(&gradient).filter(|(p, _)| p.is_some() == held);
        own.map(|(_, g)| g * g).sum::<f64>().sqrt()
    };
    let load = small.nodal_force.iter().map(|f| f * f).sum::<f64>().sqrt();
    assert_close(found.unbalanced(), norm_of(false) / (norm_of(true) + load), 1e-9);
}

/// Flat cells delay the contraction: a prediction nearby takes more than four Newton steps, and one far away has no estimate after four.
#[test]
fn flat_cells_take_more_steps_near_an_equilibrium_alone() {
    let gravity = Load::BodyForce([0.0, 0.0, -9.8e-3]); // kPa/mm
    let beam = scene(NeoHookean, box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 80]));
    let beam = beam.load(gravity).lower().unwrap();
    // By a part of the height of a cell.
    let beside = |truth: &[f64], part: f64| -> Vec<f64> {
        let wave = |i: usize| 0.125 * (2.4 * i as f64).sin();
        truth.iter().enumerate().map(|(i, u)| u + part * wave(i)).collect()
    };
    let soft = solve(&beam, &[8.0, 8.0]).unwrap().displacement;
    for part in [0.3, 0.4] {
        let wrong = beside(&soft, part);
        let found = estimate(&beam, &wrong, &[8.0, 8.0]);
        let ratio = mean(&wrong, &soft) / found.distance.unwrap().mean;
        assert!(found.newton_steps > 4 && (ratio - 1.0).abs() < 1e-3, "{part}: {ratio}");
    }
    let stiff = solve(&beam, &[80.0, 80.0]).unwrap().displacement;
    let found = estimate(&beam, &beside(&stiff, 0.3), &[80.0, 80.0]);
    let diverges = matches!(found.distance, Err(NotNearEquilibrium::Diverges { steps: 4, .. }));
    assert!(diverges, "{found:?}");
}
