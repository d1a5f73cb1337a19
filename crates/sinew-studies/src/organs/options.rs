//! Command line.

use crate::organs::scenes::{ORGANS, PARTS};
use clap::Parser;
use serde::{Deserialize, Serialize};
use sinew::case::RecipeName;
use sinew_emulate::Budget;
use std::path::PathBuf;
use std::time::Duration;

/// Train emulators of the thesis' organs and measure them against the finite-element solver.
///
/// Scenes are run one after the other; --resume continues a run that was killed. Liver and ventricle are published
/// meshes that do not come with this program: without them a made body stands in for the scene `ventricle`,
/// and liver and ventricle-thesis are left out, which the report says. The report holds what this call
/// ran or resumed.
#[derive(Parser, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[command(name = "cargo xtask reproduce-organs", version, max_term_width = 110)]
pub struct Options {
    /// Scenes to run, separated by commas [default: all]
    #[arg(long, value_delimiter = ',', value_parser = keys().collect::<Vec<_>>())]
    pub only: Vec<String>,
    /// Wall time of all trainings together, such as 20m or 2h; each scene gets its share
    #[arg(long, value_parser = humantime::parse_duration, conflicts_with = "quick")]
    pub budget: Option<Duration>,
    /// Same code on small meshes with few simulations and steps: a check, not a result
    #[arg(long)]
    pub quick: bool,
    /// Recipes to train
    #[arg(long, value_delimiter = ',', value_enum, default_value = "pi,taylor,regression")]
    pub recipe: Vec<RecipeName>,
    /// Folder with left_ventricle.vtk and liver.vtk; optional
    #[arg(long, default_value = "../shared/meshes")]
    pub meshes: PathBuf,
    /// Folder with surfaces of a real heart, such as patient1_LV_ENDOCARDIAL_000.vtk; optional
    #[arg(long, default_value = "../shared/meshes/biv-me")]
    pub hearts: PathBuf,
    /// Seed that all seeds of the run derive from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for report, fields and emulators
    #[arg(long, default_value = "out/reproduce-organs")]
    pub out: PathBuf,
    /// Keep the finished parts of an earlier run with the same options, and run the rest
    #[arg(long)]
    #[serde(skip)]
    pub resume: bool,
}

/// Names of everything that can be run.
pub fn keys() -> impl Iterator<Item = &'static str> {
    ORGANS.iter().map(|organ| organ.key).chain(PARTS.iter().map(|part| part.key))
}

impl Options {
    /// Whether a scene is to be run.
    pub fn wants(&self, key: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|only| only == key)
    }

    /// Length of a training that takes `minutes` by default: its share of the budget, if there is one; in a quick check
    /// `quick_steps` steps.
    pub fn training(&self, minutes: f64, quick_steps: usize) -> Budget {
        match self.quick {
            true => Budget::Steps(quick_steps),
            false => Budget::Seconds(self.seconds(minutes)),
        }
    }

    /// Budget \[s\].
    fn seconds(&self, minutes: f64) -> f64 {
        let share =
            self.budget.map_or(1.0, |budget| budget.as_secs_f64() / (60.0 * self.minutes()));
        60.0 * minutes * share
    }

    /// Training time by default of everything that is run \[min\].
    fn minutes(&self) -> f64 {
        let networks = self.recipe.iter().filter(|recipe| recipe.is_network()).count();
        let organs = ORGANS.iter().filter(|organ| self.wants(organ.key));
        let organs: f64 = organs.map(|organ| organ.minutes * networks as f64).sum();
        let parts = PARTS.iter().filter(|part| self.wants(part.key));
        organs + parts.map(|part| (part.minutes)()).sum::<f64>()
    }
}
