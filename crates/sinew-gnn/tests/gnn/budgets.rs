//! Budgets of a training, shared by its stages.

use crate::support::{beam, small_network, steps};
use sinew_emulate::{Budget, Emulator, Observer, Progress, TrainingOptions};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Magnitude, Parameter, Scene, Support};
use sinew_gnn::recipe::{DataDriven, PhysicsInformed};
use sinew_gnn::{OutputCoordinates, Recipe};
use sinew_mesh::box_tetrahedra;
use std::ops::ControlFlow;

/// Steps of the stages of a training, and the seconds that each of them has.
#[derive(Default)]
struct Stages {
    steps: Vec<usize>,
    seconds: Vec<f64>,
    /// Stage whose seconds were told last.
    latest: String,
}

impl Observer for Stages {
    fn progress(&mut self, progress: &Progress<'_>) -> ControlFlow<()> {
        let is_new = progress.stage != self.latest && progress.fraction < 1.0;
        if progress.stage.starts_with("train ") && is_new {
            self.latest = progress.stage.into();
            self.seconds.push(progress.seconds_left / (1.0 - progress.fraction));
        }
        ControlFlow::Continue(())
    }

    fn finished(&mut self, stage: &str, outcome: &str, _: f64) {
        if stage.starts_with("train ") {
            let steps = outcome.split_whitespace().next().unwrap();
            self.steps.push(steps.parse().unwrap());
        }
    }
}

fn train<'b>(
    recipe: Recipe,
    body: &'b sinew_emulate::Body,
    budget: Budget,
) -> (Stages, Emulator<'b>) {
    let mut stages = Stages::default();
    let options =
        TrainingOptions { budget, held_out: 2, evaluations: 1, ..TrainingOptions::default() };
    let emulator = recipe.train(body, &options, &mut stages).unwrap();
    (stages, emulator)
}

#[test]
fn a_budget_is_split_over_the_stages() {
    let body = beam(1.0);
    let base = PhysicsInformed::default();
    let of = |count: usize| steps(&base.training, count);
    let recipe = PhysicsInformed {
        parameter_sets: 16,
        coordinates: OutputCoordinates::MotionsAfter(of(50)),
        network: small_network(),
        training: of(150),
    };
    let train = |budget| train(recipe.clone().into(), &body, budget).0;
    assert_eq!(train(Budget::Effort(0.1)).steps, [5, 15]);
    assert_eq!(train(Budget::Steps(40)).steps, [10, 30]);
    // Without simulations all but a twentieth of the time is for training.
    let [first, second] = train(Budget::Seconds(0.8)).seconds[..] else { panic!("two stages") };
    assert!((first - 0.19).abs() < 1e-9 && (second - 0.57).abs() < 1e-9, "{first} {second}");
}

#[test]
fn simulations_leave_some_time_for_training() {
    let body = beam(1.0);
    let base = DataDriven::default();
    let training = steps(&base.training, 40);
    let recipe = DataDriven { simulations: 60, network: small_network(), training, ..base };
    for seconds in [0.2, 1.5] {
        let (stages, emulator) = train(recipe.clone().into(), &body, Budget::Seconds(seconds));
        let spent = emulator.record.simulate_s;
        let expected = (0.95 * (seconds - spent)).max(0.2 * seconds);
        // A first step that outlasts the budget does not tell it.
        for found in stages.seconds {
            assert!((found - expected).abs() < 1e-9, "{found} after {spent} of {seconds}");
        }
    }
}

/// Without a load at the centre of the ranges, sizes are those at parameters to train at.
#[test]
fn a_pressure_about_zero_is_learned_by_its_energy() {
    let pressed = Load::Pressure { facets: "z_max".into(), magnitude: Magnitude::Theta(2) };
    let plate = Scene::new(box_tetrahedra([20.0, 20.0, 4.0], [4, 4, 1]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
        .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
        .parameter(Parameter::linear("p", "kPa", -4.0..=4.0))
        .load(pressed);
    let edges = ["x_min", "x_max", "y_min", "y_max"].map(Support::clamped);
    let body = edges.into_iter().fold(plate, Scene::support).lower().unwrap();
    let base = PhysicsInformed::default();
    let of = |count: usize| steps(&base.training, count);
    let recipe = PhysicsInformed {
        parameter_sets: 64,
        coordinates: OutputCoordinates::MotionsAfter(of(30)),
        network: small_network(),
        training: of(60),
    };
    let (_, emulator) = train(recipe.into(), &body, Budget::Effort(1.0));
    let ends = emulator.predict(&[vec![70.0, 70.0, 4.0], vec![70.0, 70.0, 0.0]]).unwrap();
    let estimate = |case| emulator.estimate(&ends, case).unwrap().distance.expect("an equilibrium");
    let size = body.positions.len() as f64;
    let mean = ends.field(0).chunks(3).map(sinew_emulate::parts::norm).sum::<f64>() / size;
    let errors = [0, 1].map(|case| estimate(case).mean / mean);
    println!("{mean} mm, {errors:?}, {:?}", emulator.record.warnings);
    assert!(errors.iter().all(|error| *error < 0.1), "{errors:?}");
}
