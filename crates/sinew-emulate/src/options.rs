//! How much is spent on an emulator, and where it is kept.

use crate::{Design, Error, Result};
use serde::{Deserialize, Serialize};
use sinew_gnn::{Backend, Budget as Length, TrainingConfig};
use std::path::PathBuf;

/// How much is spent on an emulator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Budget {
    /// The recipe's own numbers of training steps times a factor: repeatable, and resumed bit for bit.
    Effort(f64),
    /// Training steps in all: repeatable as well.
    Steps(usize),
    /// Wall time of simulations and training together \[s\].
    Seconds(f64),
}

impl Budget {
    /// Whether nothing is to be trained.
    pub(crate) fn is_nothing(self) -> bool {
        matches!(self, Self::Steps(0) | Self::Effort(0.0))
    }
}

impl Default for Budget {
    fn default() -> Self {
        Self::Effort(1.0)
    }
}

/// What all recipes need to know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrainingOptions {
    /// How much is spent.
    pub budget: Budget,
    /// Seed that all seeds derive from.
    pub seed: u64,
    /// How the parameters of simulations and of training are spread.
    pub design: Design,
    /// Parameters to train at in place of a design, within the ranges of the body's parameters.
    pub thetas: Option<Vec<Vec<f64>>>,
    /// Simulations at uniform parameters that nothing is trained on: they check the error estimate, and the
    /// curves of a training are drawn over them.
    pub held_out: usize,
    /// Points of the training curves.
    pub evaluations: usize,
    /// Folder of simulations to learn from in place of new ones, such as [`crate::merge`] leaves.
    pub simulations: Option<PathBuf>,
    /// Folder of another run whose networks this one starts from, be it of another body with another mesh: the recipe
    /// and the parameters must be the same. Coordinates about a first training's prediction are then about one solution
    /// instead, for the centre of the ranges. With a budget of zero the networks are taken as they are.
    pub start: Option<PathBuf>,
    /// Tensor backend of networks.
    pub backend: Backend,
    /// Simulations, checkpoints and the emulator are kept here; nowhere if `None`.
    #[serde(skip)]
    pub folder: Option<PathBuf>,
    /// Folder in which runs of one case share their simulations, by body and samples; each keeps its own if `None`.
    #[serde(skip)]
    pub shared: Option<PathBuf>,
    /// Whether to go on with the run in the folder. A folder that holds a run, finished or not, is refused unless this or
    /// `restart` is set.
    #[serde(skip)]
    pub resume: bool,
    /// Whether to replace the run in the folder, where it is not resumed.
    #[serde(skip)]
    pub restart: bool,
}

impl Default for TrainingOptions {
    fn default() -> Self {
        Self {
            budget: Budget::default(),
            seed: 1,
            design: Design::default(),
            thetas: None,
            held_out: 20,
            evaluations: 20,
            simulations: None,
            start: None,
            backend: Backend::default(),
            folder: None,
            shared: None,
            resume: false,
            restart: false,
        }
    }
}

impl TrainingOptions {
    /// Requires a budget and held-out cases.
    pub(crate) fn check(&self) -> Result<()> {
        let advice = "give a positive finite number";
        let setting = |what, value| Err(Error::Setting { what, value, advice });
        match self.budget {
            budget if budget.is_nothing() && self.start.is_some() => {}
            Budget::Effort(f) if !(f > 0.0 && f.is_finite()) => return setting("the effort", f),
            Budget::Seconds(s) if !(s > 0.0 && s.is_finite()) => {
                return setting("the budget in seconds", s);
            }
            Budget::Steps(0) => return setting("the budget in steps", 0.0),
            _ => {}
        }
        match self.held_out {
            0 | 1 => Err(Error::Setting {
                what: "the number of held-out cases",
                value: self.held_out as f64,
                advice: "give at least 2: they check error estimates",
            }),
            _ => Ok(()),
        }
    }
}

/// Scales the stages of a training to a budget. `spent` is the time that simulations took \[s\].
pub(crate) fn scale(stages: &mut [&mut TrainingConfig], budget: Budget, spent: f64) {
    let total: f64 = stages.iter().map(|stage| cost(stage)).sum();
    let steps: f64 = stages.iter().map(|stage| steps_of(stage)).sum();
    for stage in stages {
        let scaled = |factor: f64, stage: &TrainingConfig| {
            Length::Steps(((steps_of(stage) * factor).round() as usize).max(1))
        };
        stage.budget = match budget {
            Budget::Effort(factor) => scaled(factor, stage),
            Budget::Steps(count) => scaled(count as f64 / steps, stage),
            Budget::Seconds(seconds) => {
                let left = (TRAINING_SHARE * (seconds - spent)).max(LEAST_TRAINING * seconds);
                Length::Seconds(left * cost(stage) / total)
            }
        };
    }
}

/// Share of what simulations leave of a time budget that training may use; the rest is for evaluations on the way.
const TRAINING_SHARE: f64 = 0.95;
/// Share of a time budget that training uses at least.
const LEAST_TRAINING: f64 = 0.2;
/// Cost of one message-passing pass with its update, and of one decoders' update, in decoded parameter sets: on the
/// thesis' beams a step takes 120 ms with eight of them, and with embeddings that are weights of their own 14.5 ms, or 23 ms
/// with 32.
const PASS_COST: f64 = 300.0;
const DECODER_COST: f64 = 33.0;

fn steps_of(config: &TrainingConfig) -> f64 {
    match config.budget {
        Length::Steps(steps) => steps as f64,
        Length::Seconds(_) => 0.0,
    }
}

/// Cost of a training in decoded parameter sets.
pub(crate) fn cost(config: &TrainingConfig) -> f64 {
    let step = config.embedding_share * PASS_COST + DECODER_COST + config.batch as f64;
    step * steps_of(config)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stages() -> [TrainingConfig; 2] {
        let config = |steps, batch| TrainingConfig {
            budget: Length::Steps(steps),
            batch,
            ..TrainingConfig::default()
        };
        [config(500, 4), config(1500, 4)]
    }

    fn scaled(budget: Budget, spent: f64) -> [Length; 2] {
        let [mut first, mut second] = stages();
        scale(&mut [&mut first, &mut second], budget, spent);
        [first.budget, second.budget]
    }

    #[test]
    fn a_budget_is_split_over_the_stages() {
        assert_eq!(scaled(Budget::Effort(0.5), 0.0), [Length::Steps(250), Length::Steps(750)]);
        assert_eq!(scaled(Budget::Steps(400), 0.0), [Length::Steps(100), Length::Steps(300)]);
        let seconds = |spent| {
            scaled(Budget::Seconds(100.0), spent).map(|length| match length {
                Length::Seconds(seconds) => seconds,
                Length::Steps(_) => f64::NAN,
            })
        };
        let [first, second] = seconds(20.0);
        assert!((first - 19.0).abs() < 1e-9 && (second - 57.0).abs() < 1e-9, "{first} {second}");
        // Simulations that ate the budget leave some for training all the same.
        assert!((seconds(1000.0).iter().sum::<f64>() - 20.0).abs() < 1e-9);
    }

    #[test]
    fn budgets_that_admit_nothing_are_refused() {
        for budget in [Budget::Effort(0.0), Budget::Seconds(f64::NAN), Budget::Steps(0)] {
            let options = TrainingOptions { budget, ..TrainingOptions::default() };
            assert!(matches!(options.check(), Err(Error::Setting { .. })), "{budget:?}");
        }
        let options = TrainingOptions { held_out: 0, ..TrainingOptions::default() };
        assert!(options.check().unwrap_err().to_string().contains("held-out"));
    }
}
