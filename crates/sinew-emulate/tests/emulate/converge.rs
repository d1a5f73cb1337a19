//! Quasi-Newton answers with a neighbour's stiffness against solves.

use sinew_emulate::{Answers, Body, Design};
use sinew_energy::laws::NeoHookean;
use sinew_energy::metrics::displacement_error;
use sinew_energy::{Load, Parameter, Scene, Support};
use sinew_fem::{Options, SolveError, Solver, neighbours};
use sinew_mesh::box_tetrahedra;

/// A block whose bulk stiffness spans two decades: what a neighbour's stiffness is wrong in is stiff.
fn block() -> Body {
    Scene::new(box_tetrahedra([60.0, 30.0, 30.0], [4, 2, 2]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 1.0..=5.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=100.0))
        .load(Load::BodyForce([3e-3, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap()
}

/// Mean nodal distance relative to the mean nodal displacement.
fn relative(truth: &[f64], found: &[f64]) -> f64 {
    let sum = |other: &[f64]| displacement_error(truth, other).iter().sum::<f64>();
    sum(found) / sum(&vec![0.0; truth.len()])
}

#[test]
fn errors_of_neighbours_answers_are_not_understated() {
    let body = block();
    let thetas = Design::LatinHypercube.sample(&body.parameters, 200, 5).unwrap();
    let (mut solver, options) = (Solver::new(&body).unwrap(), Options::default());
    let (mut near, mut found) = (None::<Vec<f64>>, 0);
    for case in neighbours(&thetas) {
        let theta = &thetas[case];
        for accuracy in [1e-2, 1e-3, 1e-5] {
            let Some(from) = &near else { continue };
            let answer = solver.converge(from, theta, accuracy, 8).unwrap();
            if answer.error.is_infinite() {
                continue;
            }
            let truth = Solver::new(&body).unwrap().solve(theta, &options).unwrap().displacement;
            let error = relative(&truth, &answer.displacement);
            assert!(answer.error <= accuracy && answer.steps <= 8);
            assert!(error <= accuracy, "{theta:?}: {error:.1e} for {:.1e}", answer.error);
            found += 1;
        }
        near = Some(solver.solve(theta, &options).unwrap().displacement);
    }
    assert!(found > 300, "{found} of 597 contract");
}

#[test]
fn far_from_equilibrium_there_is_no_answer() {
    let body = block();
    let mut solver = Solver::new(&body).unwrap();
    let (soft, stiff) = ([1.0, 1.0], [5.0, 100.0]);
    let rest = vec![0.0; 3 * body.nodes];
    assert!(matches!(solver.converge(&rest, &soft, 1e-3, 8), Err(SolveError::Singular)));
    let stiff = solver.solve(&stiff, &Options::default()).unwrap().displacement;
    assert_eq!(solver.converge(&stiff, &soft, 1e-3, 4).unwrap().error, f64::INFINITY);
    let inverted: Vec<f64> = body.positions.iter().flatten().map(|x| -2.0 * x).collect();
    assert_eq!(solver.converge(&inverted, &soft, 1e-3, 8).unwrap().error, f64::INFINITY);
    assert!(solver.converge(&rest[1..], &soft, 1e-3, 8).is_err());
}

/// A thin strip that bends and hangs over, over a wide range of stiffness: one step along stiff modes shortens those that follow, whatever
/// the bending lacks.
fn strip() -> Body {
    Scene::new(box_tetrahedra([80.0, 20.0, 3.0], [16, 4, 1]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 20.0..=400.0))
        .parameter(Parameter::log("lambda", "kPa", 20.0..=800.0))
        .load(Load::BodyForce([1e-3, 0.0, -5e-3]))
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap()
}

#[test]
fn soft_modes_do_not_hide_behind_stiff_ones() {
    let body = strip();
    let thetas = Design::LatinHypercube.sample(&body.parameters, 250, 31).unwrap();
    let mut solver = Solver::new(&body).unwrap();
    for accuracy in [1e-2, 1e-3] {
        let found = Answers::to(&body, &thetas, accuracy, None, &mut ()).unwrap();
        let mut without = 0;
        for (theta, answer) in thetas.iter().zip(found.answers) {
            let answer = answer.unwrap();
            let from = &answer.displacement;
            let truth = solver.solve_from(from, theta, &Options::default()).unwrap();
            let error = relative(&truth.displacement, from);
            assert!(error <= accuracy, "{theta:?}: {error:.1e} for {:.1e}", answer.error);
            without += usize::from(answer.steps == 0);
        }
        assert!(without > 50, "{without} of 250 without a Newton step");
    }
}
