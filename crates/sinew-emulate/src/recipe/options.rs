//! Budget and folder of a training.

use crate::error::require;
use crate::{Design, Result};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Anchors at most: beyond, their functions take longer than quasi-Newton steps.
const MOST_ANCHORS: usize = 50;

/// Budget for making an emulator.
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
    pub fn is_nothing(self) -> bool {
        matches!(self, Self::Steps(0) | Self::Effort(0.0))
    }
}

impl Default for Budget {
    fn default() -> Self {
        Self::Effort(1.0)
    }
}

/// Options of all recipes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrainingOptions {
    /// Budget for making the emulator.
    pub budget: Budget,
    /// Seed that all seeds derive from.
    pub seed: u64,
    /// Design of the parameter sets of simulations and of training.
    pub design: Design,
    /// Parameters to train at in place of a design, within the ranges of the body's parameters.
    pub thetas: Option<Vec<Vec<f64>>>,
    /// Held-out simulations at uniform parameters. They check the error estimate and give the training curves.
    pub held_out: usize,
    /// Solved states that an expansion goes through, or the outputs of a network by energy: the one at the centre of
    /// the ranges, and others that are added where the error is largest. They count as simulations.
    pub anchors: usize,
    /// Points of the training curves.
    pub evaluations: usize,
    /// Folder of simulations to learn from in place of new ones, such as [`crate::merge`] leaves.
    pub simulations: Option<PathBuf>,
    /// Folder of another run whose networks this one fine-tunes. Recipe and parameters must be the same; body and mesh may
    /// differ. Motions about the prediction of a first training are then taken about one solution at the centre of the
    /// ranges. With a budget of zero the networks stay unchanged.
    #[doc(alias("fine-tuning", "transfer learning"))]
    pub start: Option<PathBuf>,
    /// Tensor backend of networks, by name.
    pub backend: String,
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
            anchors: 1,
            evaluations: 20,
            simulations: None,
            start: None,
            backend: "flex".into(),
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
        let (what, budget) = match self.budget {
            Budget::Effort(factor) => ("the effort", factor),
            Budget::Seconds(seconds) => ("the budget in seconds", seconds),
            Budget::Steps(steps) => ("the budget in steps", steps as f64),
        };
        let trains = budget > 0.0 && budget.is_finite();
        let makes_sense = trains || self.budget.is_nothing() && self.start.is_some();
        require(makes_sense, what, budget, "give a positive finite number")?;
        let (anchors, held_out) = (self.anchors as f64, self.held_out as f64);
        let advice =
            "give 1 to 50: a regression of as many simulations is the better choice beyond";
        let makes_sense = (1..=MOST_ANCHORS).contains(&self.anchors);
        require(makes_sense, "the number of anchors", anchors, advice)?;
        let advice = "give at least 2: they check error estimates";
        require(self.held_out >= 2, "the number of held-out cases", held_out, advice)
    }
}
