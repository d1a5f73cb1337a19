//! Budgets of a training, shared by its stages.

use crate::support::{beam, small_network, steps};
use sinew_emulate::{Budget, Emulator, Observer, Progress, TrainingOptions};
use sinew_gnn::recipe::{DataDriven, PhysicsInformed};
use sinew_gnn::{OutputCoordinates, Recipe};
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
