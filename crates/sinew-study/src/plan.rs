//! How much is simulated and trained: the default run, the quick check, a time budget, the thesis' schedule.

use crate::options::{BeamOptions, Method};
use serde::{Deserialize, Serialize};
use sinew_gnn::{Budget, OptimiserConfig, Schedule, TrainingConfig};
use std::time::Duration;

/// Training of one emulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
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
        let training = Self::default_run(scene, method, options.seed);
        let training = if options.quick {
            TrainingConfig { budget: Budget::Steps(40), batch: 8, evaluations: 4, ..training }
        } else if options.full {
            Self::thesis(options.seed)
        } else if let Some(budget) = options.budget {
            let seconds = Self::seconds(options, budget, scene, method);
            TrainingConfig { budget: Budget::Seconds(seconds), ..training }
        } else {
            training
        };
        Self { training }
    }

    /// Steps and batches that reach the accuracy in docs/design.md.
    fn default_run(scene: &str, method: Method, seed: u64) -> TrainingConfig {
        let (batch, steps, learning_rate) = match (method, scene) {
            (Method::Dd | Method::Fdd, _) => (25, 1200, 3e-3),
            (Method::Pi, "once") => (4, 6000, 4e-3),
            (Method::Pi, _) => (4, 2000, 4e-3),
        };
        TrainingConfig {
            batch,
            budget: Budget::Steps(steps),
            learning_rate,
            seed,
            evaluations: 40,
            ..TrainingConfig::default()
        }
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
        let cost = |scene: &str, method: Method| {
            let plan = Self::default_run(scene, method, 0);
            let Budget::Steps(steps) = plan.budget else { return 0.0 };
            // A step costs one message-passing pass, which is worth about 16 decoded parameter sets.
            steps as f64 * (16.0 + plan.batch as f64)
        };
        let total: f64 = options
            .scene
            .names()
            .iter()
            .flat_map(|scene| options.method.iter().map(|&method| cost(scene, method)))
            .sum();
        TRAINING_SHARE * budget.as_secs_f64() * cost(scene, method) / total
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
        let seconds = |scene, method| match Plan::of(&options, scene, method).training.budget {
            Budget::Seconds(seconds) => seconds,
            Budget::Steps(_) => 0.0,
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
