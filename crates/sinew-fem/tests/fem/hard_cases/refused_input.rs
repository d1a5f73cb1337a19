//! Input that makes no sense, refused before anything is computed.

use crate::hard_cases::bodies::*;
use crate::hard_cases::checks::*;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Scene, SceneError, Support, ThetaError};
use sinew_fem::{Advice, Options, SolveError, Solver};

#[test]
fn theta_of_the_wrong_length_is_refused_with_both_lengths() {
    let beam = once();
    for theta in [&[][..], &[75.0], &[75.0; 3]] {
        let given = theta.len();
        let expected = ThetaError::Length { given, needed: 2, names: vec!["mu", "lambda"] };
        assert_eq!(solve(&beam, theta).unwrap_err(), SolveError::Theta(expected));
    }
}

#[test]
fn parameters_that_are_not_those_of_law_and_loads_are_refused() {
    for names in [&["mu"][..], &["mu", "lambda", "p"]] {
        let scene = Scene { parameters: parameters(names), ..scene(NeoHookean, cube(1)) };
        let given = names.len();
        let expected = SceneError::Parameters(format!(
            "the scene lists {given} parameters, but the law reads mu, lambda and the loads 0 more; list those of the law first"
        ));
        assert_eq!(scene.lower().unwrap_err(), expected);
    }
}

#[test]
fn ranges_that_are_none_are_refused() {
    for range in [[2.0, 1.0], [f64::NAN, 1.0], [0.0, 1.0], [1.0, f64::INFINITY]] {
        let mut scene = scene(NeoHookean, cube(1));
        scene.parameters[1].range = range;
        assert!(matches!(scene.lower().unwrap_err(), SceneError::Range { .. }), "{range:?}");
    }
}

#[test]
fn an_initial_displacement_of_the_wrong_length_or_no_numbers_is_refused() {
    let beam = once();
    let mut solver = Solver::new(&beam).unwrap();
    let mut from = |initial: &[f64]| {
        solver.solve_from(initial, &[75.0, 75.0], &Options::default()).unwrap_err()
    };
    let expected = SolveError::Initial { given: 3, finite: 3, needed: 1170 };
    assert_eq!(from(&[0.0; 3]), expected);
    let expected = SolveError::Initial { given: 1170, finite: 0, needed: 1170 };
    assert_eq!(from(&[f64::NAN; 1170]), expected);
}

#[test]
fn an_initial_state_of_inverted_cells_is_left_for_load_steps() {
    let beam = once();
    let mut solver = Solver::new(&beam).unwrap();
    let tangled: Vec<_> = (0..1170).map(|i| ((i * 7919) % 101) as f64).collect();
    let cold = solver.solve(&[75.0, 75.0], &Options::default()).unwrap();
    for initial in [tangled, vec![1e200; 1170], vec![f64::MAX; 1170]] {
        let solution = solver.solve_from(&initial, &[75.0, 75.0], &Options::default()).unwrap();
        assert!(difference(&solution.displacement, &cold.displacement) < 1e-10);
    }
}

#[test]
fn the_solution_of_another_body_is_refused() {
    let (beam, other) = (once(), lower(NeoHookean, cube(1), vec![], pulled(0.1)));
    let foreign = solve(&other, &[1.0, 1.0]).unwrap();
    let mut solver = Solver::new(&beam).unwrap();
    let expected = SolveError::Initial { given: 24, finite: 24, needed: 1170 };
    assert_eq!(solver.sensitivity(&foreign).unwrap_err(), expected);
    assert_eq!(solver.stiffness(&foreign).unwrap_err(), expected);
}

#[test]
fn limits_on_iterations_are_kept() {
    let beam = once();
    let mut solver = Solver::new(&beam).unwrap();
    for iterations in [0, 1, 3] {
        let options = Options { iterations, ..Options::default() };
        let failure = failure(solver.solve(&[75.0, 75.0], &options));
        assert_eq!(failure.history.iterations.len(), iterations);
        assert_eq!(failure.advice, Advice::MoreIterations);
        assert_eq!(failure.load_factor, 0.0);
    }
}

#[test]
fn limits_on_load_steps_are_kept() {
    // Needs load steps: a column that is pressed flat.
    let mesh = cube(2);
    let supports = vec![
        Support::clamped("x_min"),
        Support::uniform("x_max", [Some(-0.99), Some(0.0), Some(0.0)]),
    ];
    let body = lower(NeoHookean, mesh, vec![], supports);
    let mut solver = Solver::new(&body).unwrap();
    let reached = [1.0, 0.2, 1e-4].map(|least_load_step| {
        let options = Options { least_load_step, ..Options::default() };
        match solver.solve(&[1.0, 1.0], &options) {
            Ok(_) => 1.0,
            Err(SolveError::NotConverged(failure)) => failure.load_factor,
            Err(other) => panic!("{other}"),
        }
    });
    println!("{reached:?}");
    assert_eq!(reached[0], 0.0);
    assert!(reached[1] <= reached[2] && reached[2] > 0.5);
}

#[test]
fn least_load_steps_that_make_no_sense_end_in_a_solution_or_a_typed_failure() {
    let supports = vec![
        Support::clamped("x_min"),
        Support::uniform("x_max", [Some(-1.5), Some(0.0), Some(0.0)]),
    ];
    let body = lower(NeoHookean, cube(1), vec![], supports);
    for least_load_step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = Options { least_load_step, ..Options::default() };
        let failure = failure(Solver::new(&body).unwrap().solve(&[1.0, 1.0], &options));
        assert!(failure.load_factor < 1.0);
    }
}
