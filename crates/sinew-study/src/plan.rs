//! How much is simulated and trained: the default run, the quick check, a time budget, the thesis' schedule.

use crate::options::{BeamOptions, Method};
use serde::{Deserialize, Serialize};
use sinew_gnn::{Budget, OptimiserConfig, Schedule, TrainingConfig};
use std::time::Duration;

/// Training of one emulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// A first, short training, whose prediction at the centre of the parameter range anchors the
    /// coordinates of the second, see [`crate::basis`]; `None` trains once, one scale per component.
    pub anchoring: Option<TrainingConfig>,
    /// Optimiser, schedule, batch, steps or seconds.
    pub training: TrainingConfig,
}

/// Numbers of simulations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Samples {
    /// Latin hypercube for training.
    pub training: usize,
    /// Uniform points that the training curves are drawn over.
    pub validation: usize,
    /// Uniform points that every error in the tables is over.
    pub test: usize,
    /// Latin hypercube for the regression rival.
    pub pod: usize,
}

impl Samples {
    /// The thesis' 200 and 100; few for a quick check.
    pub fn of(options: &BeamOptions) -> Self {
        if options.quick {
            Self { training: 32, validation: 4, test: 8, pod: 12 }
        } else {
            Self { training: 200, validation: 20, test: 100, pod: 25 }
        }
    }
}

/// Share of a time budget that training may use; the rest is for simulations, evaluation and report.
const TRAINING_SHARE: f64 = 0.88;

impl Plan {
    /// The plan of one emulator in a run.
    pub fn of(options: &BeamOptions, scene: &str, method: Method) -> Self {
        let plan = Self::default_run(method, options.seed);
        if options.full {
            Self { anchoring: None, training: Self::thesis(options.seed) }
        } else if options.quick {
            plan.map(|_| Budget::Steps(20), 2)
        } else if let Some(budget) = options.budget {
            let seconds = Self::seconds(options, budget, scene, method);
            let steps = plan.steps();
            let share = |config: &TrainingConfig| seconds * step_count(config) / steps;
            let evaluations = plan.training.evaluations;
            plan.map(|config| Budget::Seconds(share(config)), evaluations)
        } else {
            plan
        }
    }

    /// Steps and batches that reach the accuracy in docs/design.md.
    fn default_run(method: Method, seed: u64) -> Self {
        let config = |batch, steps, learning_rate, evaluations| TrainingConfig {
            batch,
            budget: Budget::Steps(steps),
            learning_rate,
            seed,
            evaluations,
            ..TrainingConfig::default()
        };
        match method {
            Method::Dd | Method::Fdd => {
                Self { anchoring: None, training: config(25, 1500, 3e-3, 30) }
            }
            Method::Pi => Self {
                anchoring: Some(config(4, 1000, 4e-3, 10)),
                training: config(4, 2000, 4e-3, 20),
            },
        }
    }

    fn map(mut self, budget: impl Fn(&TrainingConfig) -> Budget, evaluations: usize) -> Self {
        for config in self.anchoring.iter_mut().chain([&mut self.training]) {
            config.budget = budget(config);
            config.evaluations = evaluations.min(config.evaluations);
        }
        self
    }

    fn steps(&self) -> f64 {
        self.anchoring.iter().chain([&self.training]).map(step_count).sum()
    }

    /// The thesis' schedule (§3.3.1): 5000 epochs of 200 samples, one by one, Adam at 1e-4.
    fn thesis(seed: u64) -> TrainingConfig {
        TrainingConfig {
            optimiser: OptimiserConfig::adam(),
            learning_rate: 1e-4,
            schedule: Schedule::Constant,
            budget: Budget::Steps(5000 * 200),
            batch: 1,
            gradient_norm_limit: None,
            seed,
            evaluations: 500,
            patience: None,
        }
    }

    /// This emulator's share of a budget, in proportion to the steps and batches of the default run.
    fn seconds(options: &BeamOptions, budget: Duration, scene: &str, method: Method) -> f64 {
        let cost = |method: Method| {
            let plan = Self::default_run(method, 0);
            plan.steps() * (PASS_COST + plan.training.batch as f64)
        };
        let scenes = options.scene.names();
        let total: f64 = options.method.iter().map(|&method| cost(method)).sum();
        let share = if scenes.contains(&scene) { 1.0 / scenes.len() as f64 } else { 0.0 };
        TRAINING_SHARE * budget.as_secs_f64() * share * cost(method) / total
    }
}

/// Cost of one message-passing pass with its update, in decoded parameter sets: on the beams a step takes 69 ms with
/// four of them and 90 ms with 25.
const PASS_COST: f64 = 66.0;

fn step_count(config: &TrainingConfig) -> f64 {
    match config.budget {
        Budget::Steps(steps) => steps as f64,
        Budget::Seconds(_) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::{Options, Study};
    use clap::Parser;

    fn options(arguments: &[&str]) -> BeamOptions {
        let start = ["sinew-study", "reproduce-beam"];
        let parsed = Options::try_parse_from(start.iter().chain(arguments)).unwrap();
        let Study::ReproduceBeam(options) = parsed.study;
        options
    }

    #[test]
    fn a_budget_is_split_without_rest() {
        let options = options(&["--budget", "10m"]);
        let seconds = |scene, method| -> f64 {
            let plan = Plan::of(&options, scene, method);
            let of = |config: &TrainingConfig| match config.budget {
                Budget::Seconds(seconds) => seconds,
                Budget::Steps(_) => 0.0,
            };
            plan.anchoring.iter().chain([&plan.training]).map(of).sum()
        };
        let total: f64 = ["once", "twice"]
            .iter()
            .flat_map(|scene| [Method::Dd, Method::Pi].map(|method| seconds(scene, method)))
            .sum();
        assert!((total - TRAINING_SHARE * 600.0).abs() < 1e-9);
        assert!(seconds("once", Method::Pi) > seconds("once", Method::Dd));
    }

    #[test]
    fn the_full_schedule_is_the_thesis() {
        let plan = Plan::of(&options(&["--full"]), "once", Method::Pi).training;
        assert_eq!((plan.budget, plan.batch), (Budget::Steps(1_000_000), 1));
        assert_eq!(plan.learning_rate, 1e-4);
    }
}
