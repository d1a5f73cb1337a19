//! Answers to an accuracy where a sweep of the solver costs less.

use crate::to_an_accuracy::true_error;
use sinew_emulate::{Answer, Answers, Design, Method};
use sinew_energy::laws::{ByYoungPoisson, NeoHookean};
use sinew_energy::{Load, Parameter, Scene, Support};
use sinew_fem::{Options, sweep};
use sinew_mesh::box_tetrahedra;

/// A slender beam whose shape turns over the ranges: steps from its expansion take more than a sweep of neighbours.
#[test]
fn an_expansion_that_takes_more_steps_than_a_sweep_leaves_the_rest_to_the_solver() {
    let mesh = box_tetrahedra([73.0, 4.0, 4.0], [8, 1, 1]).quadratic();
    let scene = Scene::new(mesh, ByYoungPoisson(NeoHookean))
        .parameter(Parameter::log("E", "kPa", 9.6..=59.0))
        .parameter(Parameter::linear("nu", "1", 0.17..=0.45))
        .load(Load::Traction { facets: "x_max".into(), value: [-7.6e-4, 1.4e-3, -5.9e-3] })
        .support(Support::clamped("x_min"));
    let body = scene.lower().unwrap();
    let thetas = Design::LatinHypercube.sample(&body.parameters, 60, 1).unwrap();
    let found = Answers::to(&body, &thetas, 1e-3, None, &mut ()).unwrap();
    assert_eq!(found.plan.method(), Method::Expansion);
    let answers: Vec<_> = found.answers.iter().map(|answer| answer.as_ref().unwrap()).collect();
    // The set that was planned with, and a third of the others.
    let by_expansion = answers.iter().filter(|answer| answer.method == Method::Expansion).count();
    assert!(by_expansion <= 19, "{by_expansion}");
    let steps: usize = answers.iter().map(|answer| answer.steps).sum();
    assert!(steps < 60 * 6, "{steps}");
    for (theta, answer) in thetas.iter().zip(&answers).step_by(7) {
        assert!(true_error(&body, theta, &answer.displacement) <= 1e-3, "{theta:?}");
    }
}

#[test]
fn sets_whose_search_from_a_prediction_fails_cost_no_more_than_in_a_sweep() {
    // A plate that hangs in folds from two of its sides.
    let mesh = box_tetrahedra([58.7, 66.5, 5.07], [7, 7, 2]);
    let scene = Scene::new(mesh, ByYoungPoisson(NeoHookean))
        .parameter(Parameter::linear("E", "kPa", 2.92..=9.91))
        .parameter(Parameter::linear("nu", "1", 0.238..=0.378))
        .load(Load::BodyForce([-0.132, 0.0, -0.611]))
        .support(Support::clamped("x_min"))
        .support(Support::clamped("y_min"));
    let body = scene.lower().unwrap();
    let thetas = Design::LatinHypercube.sample(&body.parameters, 60, 1).unwrap();
    let swept = sweep(&body, &thetas, &Options::default(), || ()).unwrap();
    let swept: usize = swept.into_iter().map(|solved| solved.unwrap().iterations()).sum();
    let found = Answers::to(&body, &thetas, 1e-2, None, &mut ()).unwrap();
    let answers: Vec<Answer> = found.answers.into_iter().map(Result::unwrap).collect();
    assert!(answers.iter().any(|answer| answer.method == Method::Expansion));
    let steps: usize = answers.iter().map(|answer| answer.steps).sum();
    assert!(steps <= swept, "{steps} Newton steps, {swept} in a sweep");
}
