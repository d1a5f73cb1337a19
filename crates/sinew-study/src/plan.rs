//! How much is simulated and trained: the default run, the quick check, a time budget, the thesis' schedule.

use crate::options::{BeamOptions, Method};
use serde::{Deserialize, Serialize};
use sinew_gnn::{Budget, OptimiserConfig, Schedule, TrainingConfig};
use std::time::Duration;

/// Training of one emulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// What the outputs of the network mean.
    pub coordinates: Coordinates,
    /// Optimiser, schedule, batch, steps or seconds.
    pub training: TrainingConfig,
}

/// What the outputs of a network mean, see [`crate::basis`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coordinates {
    /// Displacements, one scale per component (thesis).
    Components,
    /// The directions in which the simulations differ.
    Simulations,
    /// Those in which the energy is round about a simulation near the centre of the parameter range.
    StiffnessOfSimulation,
    /// The same about what a first, short training predicts for the centre, so without simulations.
    StiffnessAfter(TrainingConfig),
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

impl Plan {
    /// The plan of one emulator in a run.
    pub fn of(options: &BeamOptions, scene: &str, method: Method) -> Self {
        let plan = Self::default_run(method, options.seed);
        if options.full {
            Self { coordinates: Coordinates::Components, training: Self::thesis(options.seed) }
        } else if options.quick {
            plan.map(|_| Budget::Steps(20), 2)
        } else if let Some(budget) = options.budget {
            let seconds = Self::seconds(options, budget, scene, method);
            let total: f64 = plan.stages().map(cost).sum();
            let evaluations = plan.training.evaluations;
            plan.map(|config| Budget::Seconds(seconds * cost(config) / total), evaluations)
        } else {
            let evaluations = plan.training.evaluations;
            plan.map(|config| scaled(config.budget, options.effort), evaluations)
        }
    }

    /// Steps and batches that reach the accuracy in docs/design.md.
    fn default_run(method: Method, seed: u64) -> Self {
        let config = |batch, steps, embedding_share, evaluations| TrainingConfig {
            batch,
            budget: Budget::Steps(steps),
            embedding_share,
            seed,
            evaluations,
            ..TrainingConfig::default()
        };
        match method {
            Method::Dd | Method::Fdd => {
                Self { coordinates: Coordinates::Simulations, training: config(8, 2000, 0.1, 20) }
            }
            Method::Pi => Self {
                coordinates: Coordinates::StiffnessAfter(config(4, 500, 0.3, 5)),
                training: config(4, 1500, 0.3, 20),
            },
            Method::Hybrid => Self {
                coordinates: Coordinates::StiffnessOfSimulation,
                training: config(8, 1500, 0.15, 20),
            },
        }
    }

    /// All trainings, the first one first.
    fn stages(&self) -> impl Iterator<Item = &TrainingConfig> {
        let first = match &self.coordinates {
            Coordinates::StiffnessAfter(config) => Some(config),
            _ => None,
        };
        first.into_iter().chain([&self.training])
    }

    fn map(mut self, budget: impl Fn(&TrainingConfig) -> Budget, evaluations: usize) -> Self {
        let change = |config: &mut TrainingConfig| {
            config.budget = budget(config);
            config.evaluations = evaluations.min(config.evaluations);
        };
        if let Coordinates::StiffnessAfter(config) = &mut self.coordinates {
            change(config);
        }
        change(&mut self.training);
        self
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
            embedding_share: 1.0,
            seed,
            evaluations: 500,
            patience: None,
        }
    }

    /// This emulator's share of a budget, in proportion to the cost of the default run.
    fn seconds(options: &BeamOptions, budget: Duration, scene: &str, method: Method) -> f64 {
        let cost =
            |method: Method| -> f64 { Self::default_run(method, 0).stages().map(cost).sum() };
        let scenes = options.scene.names();
        let total: f64 = options.method.iter().map(|&method| cost(method)).sum();
        let share = if scenes.contains(&scene) { 1.0 / scenes.len() as f64 } else { 0.0 };
        let fixed = FIXED_SECONDS * scenes.len() as f64;
        let training = (budget.as_secs_f64() - fixed).max(LEAST_TRAINING * budget.as_secs_f64());
        TRAINING_SHARE * training * share * cost(method) / total
    }
}

/// What simulations, evaluation of the tests, rivals and report of one scene take \[s\].
const FIXED_SECONDS: f64 = 7.0;
/// Share of the rest that training may use; what is left is for evaluations on the way.
const TRAINING_SHARE: f64 = 0.95;
/// Share of a budget that training uses at least.
const LEAST_TRAINING: f64 = 0.2;
/// Cost of one message-passing pass with its update, and of one decoders' update, in decoded parameter sets: on the
/// beams a step takes 69 ms with four of them and 90 ms with 25, and 13 and 35 with embeddings that keep their values.
const PASS_COST: f64 = 56.0;
const DECODER_COST: f64 = 10.0;

/// A number of steps times a factor.
fn scaled(budget: Budget, factor: f64) -> Budget {
    match budget {
        Budget::Steps(steps) => Budget::Steps(((steps as f64 * factor).round() as usize).max(1)),
        Budget::Seconds(_) => budget,
    }
}

/// Cost of a training in decoded parameter sets; zero under a time budget.
fn cost(config: &TrainingConfig) -> f64 {
    let step = config.embedding_share * PASS_COST + DECODER_COST + config.batch as f64;
    match config.budget {
        Budget::Steps(steps) => step * steps as f64,
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
        match parsed.study {
            Study::ReproduceBeam(options) => options,
            other => panic!("{other:?} is another study"),
        }
    }

    #[test]
    fn a_budget_is_split_without_rest() {
        let options = options(&["--budget", "10m"]);
        let seconds = |scene, method| -> f64 {
            let of = |config: &TrainingConfig| match config.budget {
                Budget::Seconds(seconds) => seconds,
                Budget::Steps(_) => 0.0,
            };
            Plan::of(&options, scene, method).stages().map(of).sum()
        };
        let total: f64 = ["once", "twice"]
            .iter()
            .flat_map(|scene| options.method.iter().map(|&method| seconds(scene, method)))
            .sum();
        assert!((total - TRAINING_SHARE * (600.0 - 2.0 * FIXED_SECONDS)).abs() < 1e-9);
        assert!(seconds("once", Method::Pi) > 0.0);
    }

    #[test]
    fn effort_scales_all_stages() {
        let steps = |arguments: &[&str]| -> Vec<Budget> {
            let plan = Plan::of(&options(arguments), "once", Method::Pi);
            plan.stages().map(|config| config.budget).collect()
        };
        assert_eq!(steps(&["--effort", "0.5"]), [Budget::Steps(250), Budget::Steps(750)]);
        assert_eq!(steps(&[]), [Budget::Steps(500), Budget::Steps(1500)]);
    }

    #[test]
    fn the_full_schedule_is_the_thesis() {
        let plan = Plan::of(&options(&["--full"]), "once", Method::Pi);
        assert_eq!(plan.coordinates, Coordinates::Components);
        let training = plan.training;
        assert_eq!((training.budget, training.batch), (Budget::Steps(1_000_000), 1));
        assert_eq!((training.learning_rate, training.embedding_share), (1e-4, 1.0));
    }
}
