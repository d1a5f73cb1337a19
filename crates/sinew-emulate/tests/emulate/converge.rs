//! Quasi-Newton answers with a neighbour's stiffness against solves.

use sinew_emulate::{Answers, Body, Design};
use sinew_energy::laws::{ByYoungPoisson, NeoHookean};
use sinew_energy::metrics::displacement_error;
use sinew_energy::{Load, Parameter, Scene, Support};
use sinew_fem::{Options, SolveError, Solver, Stop, neighbours, sweep};
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

/// Forces along the axis of a neighbour's beam bend a beam that has turned: steps with its stiffness are short, and the error is not.
#[test]
fn answers_of_a_slender_beam_that_turns_are_within_their_tolerance() {
    let mesh = box_tetrahedra([60.0, 8.0, 6.0], [8, 1, 1]).quadratic();
    let body = Scene::new(mesh, ByYoungPoisson(NeoHookean))
        .parameter(Parameter::log("E", "kPa", 10.0..=90.0))
        .parameter(Parameter::log("nu", "1", 0.2..=0.45))
        .load(Load::BodyForce([0.0, 1e-4, -8e-4]))
        .support(Support::clamped("x_min"))
        .lower()
        .unwrap();
    let (accuracy, mut solver) = (1e-3, Solver::new(&body).unwrap());
    let thetas = Design::LatinHypercube.sample(&body.parameters, 1000, 71).unwrap();
    let found = Answers::to(&body, &thetas, accuracy, None, &mut ()).unwrap();
    for (theta, answer) in thetas.iter().zip(&found.answers) {
        let answer = &answer.as_ref().unwrap().displacement;
        let truth = solver.solve_from(answer, theta, &Options::default()).unwrap();
        let error = relative(&truth.displacement, answer);
        assert!(error <= accuracy, "{theta:?}: {error:e}");
    }
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
            let answer = solver.refine(from, theta, Stop::within(accuracy, 9)).unwrap();
            let Some(estimate) = answer.error else { continue };
            let truth = Solver::new(&body).unwrap().solve(theta, &options).unwrap().displacement;
            let error = relative(&truth, &answer.displacement);
            assert!(estimate <= accuracy && answer.steps <= 8);
            assert!(error <= accuracy, "{theta:?}: {error:.1e} for {estimate:.1e}");
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
    let to = |steps: usize| Stop::within(1e-3, steps);
    assert!(matches!(solver.refine(&rest, &soft, to(9)), Err(SolveError::Singular)));
    let stiff = solver.solve(&stiff, &Options::default()).unwrap().displacement;
    assert_eq!(solver.refine(&stiff, &soft, to(5)).unwrap().error, None);
    let inverted: Vec<f64> = body.positions.iter().flatten().map(|x| -2.0 * x).collect();
    let refused = solver.refine(&inverted, &soft, to(9)).unwrap_err();
    assert!(matches!(refused, SolveError::Inadmissible { .. }), "{refused}");
    assert!(solver.refine(&rest[1..], &soft, to(9)).is_err());
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

/// A slab that hangs from two of its sides, and a block whose Poisson's ratio comes near to one half.
fn slab_and_block() -> [Body; 2] {
    let slab = Scene::new(box_tetrahedra([60.0, 60.0, 8.0], [6, 6, 2]), NeoHookean)
        .parameter(Parameter::linear("mu", "kPa", 0.5..=8.0))
        .parameter(Parameter::linear("lambda", "kPa", 0.5..=40.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"))
        .support(Support::clamped("y_min"));
    let cells = box_tetrahedra([70.0, 45.0, 35.0], [7, 4, 3]);
    let block = Scene::new(cells, ByYoungPoisson(NeoHookean))
        .parameter(Parameter::log("E", "kPa", 0.8..=8.0))
        .parameter(Parameter::linear("nu", "1", 0.25..=0.47))
        .load(Load::BodyForce([0.0, 3e-3, -9.8e-3]))
        .support(Support::clamped("x_min"));
    [slab.lower().unwrap(), block.lower().unwrap()]
}

/// A cantilever of quadratic cells over two decades of stiffness, and a plate that weak springs hold: much of what its factors miss is soft.
fn quadratic_and_sprung() -> [Body; 2] {
    let beam = Scene::new(box_tetrahedra([60.0, 10.0, 8.0], [6, 1, 1]).quadratic(), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 10.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 10.0..=1000.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"));
    let springs = Load::Foundation { facets: "z_min".into(), normal: 0.01, tangential: 0.002 };
    let plate = Scene::new(box_tetrahedra([50.0, 40.0, 10.0], [7, 6, 2]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 0.5..=10.0))
        .parameter(Parameter::log("lambda", "kPa", 1.0..=60.0))
        .load(Load::BodyForce([4e-3, 0.0, -9.8e-3]))
        .load(springs);
    [beam.lower().unwrap(), plate.lower().unwrap()]
}

#[test]
fn answers_are_within_their_tolerance_and_take_fewer_newton_steps_than_a_sweep() {
    for (body, seed) in
        slab_and_block().iter().zip([23, 31]).chain(quadratic_and_sprung().iter().zip([5, 6]))
    {
        let thetas = Design::LatinHypercube.sample(&body.parameters, 150, seed).unwrap();
        let swept = sweep(body, &thetas, &Options::default(), || ()).unwrap();
        let truths: Vec<_> = swept.into_iter().map(Result::unwrap).collect();
        let solver: usize = truths.iter().map(|truth| truth.iterations()).sum();
        for accuracy in [2e-2, 1e-2, 1e-3, 1e-4] {
            let found = Answers::to(body, &thetas, accuracy, None, &mut ()).unwrap();
            let mut steps = 0;
            for (truth, answer) in truths.iter().zip(found.answers) {
                let answer = answer.unwrap();
                let error = relative(&truth.displacement, &answer.displacement);
                assert!(answer.is_within(accuracy) && error <= accuracy, "{error:e}");
                steps += answer.steps;
            }
            println!("{accuracy:e}: {steps} Newton steps for {solver}");
            assert!(4 * steps < 3 * solver, "{steps} Newton steps for {solver}");
        }
    }
}
