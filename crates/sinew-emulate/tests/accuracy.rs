//! Answers to an accuracy against solves.

use sinew_emulate::{
    Answers, Body, Design, Emulator, Error, Method, Plan, Train, TrainingOptions, recipe::Taylor,
};
use sinew_energy::laws::NeoHookean;
use sinew_energy::metrics::displacement_error;
use sinew_energy::{Load, Parameter, Scene, Support};
use sinew_fem::{Options, Solver};
use sinew_mesh::box_tetrahedra;

/// A bar that bends far, over a decade of stiffness: the expansion alone is 30 % off at the soft end.
fn bar() -> Body {
    let stiffness = |name: &str| Parameter::log(name, "kPa", 10.0..=100.0);
    let scene = Scene::new(box_tetrahedra([60.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
        .parameter(stiffness("mu"))
        .parameter(stiffness("lambda"))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3]))
        .support(Support::clamped("x_min"));
    scene.lower().unwrap()
}

/// Mean nodal distance from the equilibrium, relative to the mean nodal displacement.
fn true_error(body: &Body, theta: &[f64], displacement: &[f64]) -> f64 {
    let options = Options::default();
    let truth = Solver::new(body).unwrap().solve(theta, &options).unwrap().displacement;
    let sum = |a: &[f64], b: &[f64]| displacement_error(a, b).iter().sum::<f64>();
    sum(&truth, displacement) / sum(&truth, &vec![0.0; truth.len()])
}

#[test]
fn every_answer_is_truly_within_its_tolerance() {
    let body = bar();
    let thetas = Design::LatinHypercube.sample(&body.parameters, 60, 3).unwrap();
    let expansion = Emulator::series(&body, 1).unwrap();
    let raw = |theta: &Vec<f64>| {
        let predicted = expansion.predict(std::slice::from_ref(theta)).unwrap().displacement;
        true_error(&body, theta, &predicted)
    };
    let far = thetas.iter().map(raw).filter(|error| *error > 1e-2).count();
    assert!(far >= 10, "only {far} of 60 predictions need steps");
    for accuracy in [1e-2, 1e-4, 1e-8] {
        let found = Answers::to(&body, &thetas, accuracy, Some(&expansion), &mut ()).unwrap();
        assert_eq!(found.answers.len(), thetas.len());
        for (theta, answer) in thetas.iter().zip(&found.answers) {
            let answer = answer.as_ref().unwrap();
            let error = true_error(&body, theta, &answer.displacement);
            // Two solves of one equilibrium differ by rounding errors.
            assert!(
                answer.is_within(accuracy) && error <= accuracy + 1e-10,
                "{theta:?}: {error:e}"
            );
        }
    }
}

#[test]
fn a_plan_weighs_what_there_is() {
    let body = bar();
    let thetas = Design::LatinHypercube.sample(&body.parameters, 1000, 1).unwrap();
    assert_eq!(Plan::new(&body, &thetas[..1], 1e-3, None).unwrap().method(), Method::Solver);
    let plan = Plan::new(&body, &thetas, 1e-3, None).unwrap();
    assert_eq!((plan.sets, plan.costs.len()), (1000, 2));
    assert!(plan.costs.windows(2).all(|pair| pair[0].newton_steps <= pair[1].newton_steps));
    let options = TrainingOptions { held_out: 4, ..TrainingOptions::default() };
    let trained = Taylor.train(&body, &options, &mut ()).unwrap();
    let plan = Plan::new(&body, &thetas[..1], 1e-3, Some(&trained)).unwrap();
    assert_eq!(plan.method(), Method::Emulator);
}

#[test]
fn sets_without_an_equilibrium_are_told_and_the_others_answered() {
    let body = bar();
    let mut thetas = Design::LatinHypercube.sample(&body.parameters, 8, 1).unwrap();
    thetas[3] = vec![1e-9, 1e-9];
    let found = Answers::to(&body, &thetas, 1e-3, None, &mut ()).unwrap();
    assert!(found.answers[3].is_err(), "{:?}", found.answers[3]);
    let within = found.answers.iter().flatten().filter(|answer| answer.is_within(1e-3)).count();
    assert_eq!(within, 7);
}

#[test]
fn a_tolerance_that_makes_no_sense_is_refused() {
    let body = bar();
    for accuracy in [0.0, -1.0, f64::NAN, 1e-12, 0.9] {
        let refused = Answers::to(&body, &[vec![20.0, 20.0]], accuracy, None, &mut ());
        assert!(matches!(refused, Err(Error::Setting { .. })), "{accuracy}");
    }
}

#[test]
fn answers_do_not_depend_on_the_number_of_threads() {
    let body = bar();
    let thetas = Design::LatinHypercube.sample(&body.parameters, 30, 5).unwrap();
    let emulator = Emulator::series(&body, 1).unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| Answers::to(&body, &thetas, 1e-4, Some(&emulator), &mut ()));
        let answers = found.unwrap().answers;
        answers.into_iter().map(|answer| answer.unwrap().displacement).collect::<Vec<_>>()
    };
    assert_eq!(on(1), on(2));
}
