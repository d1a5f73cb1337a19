//! Command line.

use crate::organs::ORGANS;
use clap::Parser;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::Duration;

/// Train emulators of the thesis' organs and measure them against the finite-element solver.
///
/// Scenes are run one after the other; a run that was killed goes on with --resume. Two organs are published meshes that do
/// not come with this program: without them an ideal ventricle stands in for the one, and the liver is left out.
#[derive(Parser, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[command(name = "cargo xtask reproduce-organs", version, max_term_width = 110)]
pub struct Options {
    /// Scenes to run, separated by commas [default: all]
    #[arg(long, value_delimiter = ',', value_parser = key)]
    pub only: Vec<String>,
    /// Wall time of all trainings together, such as 20m or 2h; each scene gets its share
    #[arg(long, value_parser = humantime::parse_duration, conflicts_with = "quick")]
    pub budget: Option<Duration>,
    /// The same code on small meshes with few simulations and steps: a check, not a result
    #[arg(long)]
    pub quick: bool,
    /// Recipes to train
    #[arg(long, value_delimiter = ',', value_enum, default_value = "pi,regression")]
    pub recipe: Vec<sinew::case::RecipeName>,
    /// Folder of left_ventricle.vtk and liver.vtk
    #[arg(long, default_value = "../shared/meshes")]
    pub meshes: PathBuf,
    /// Folder of the surfaces of a real heart, patient1_LV_ENDOCARDIAL_000.vtk and its like
    #[arg(long, default_value = "../shared/meshes/biv-me")]
    #[serde(default)]
    pub hearts: PathBuf,
    /// Seed that all seeds of the run derive from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for report, fields and emulators
    #[arg(long, default_value = "out/reproduce-organs")]
    pub out: PathBuf,
    /// Keep what an earlier run with the same options has finished, and go on with the rest
    #[arg(long)]
    #[serde(skip)]
    pub resume: bool,
}

fn key(text: &str) -> Result<String, String> {
    let keys: Vec<&str> = keys().collect();
    match keys.contains(&text) {
        true => Ok(text.to_string()),
        false => Err(format!("`{text}` is no scene; there are: {}", keys.join(", "))),
    }
}

/// Names of everything that can be run.
pub fn keys() -> impl Iterator<Item = &'static str> {
    ORGANS.iter().map(|organ| organ.key).chain([crate::cubes::KEY, crate::newcomers::KEY])
}

impl Options {
    /// Whether a scene is to be run.
    pub fn wants(&self, key: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|only| only == key)
    }

    /// Training time of something that takes `minutes` by default \[s\].
    pub fn seconds(&self, minutes: f64) -> f64 {
        let all: f64 =
            ORGANS.iter().filter(|organ| self.wants(organ.key)).map(|organ| organ.minutes).sum();
        let all = all
            + if self.wants(crate::cubes::KEY) { crate::cubes::MINUTES } else { 0.0 }
            + if self.wants(crate::newcomers::KEY) { crate::newcomers::MINUTES } else { 0.0 };
        let share = self.budget.map_or(1.0, |budget| budget.as_secs_f64() / (60.0 * all));
        60.0 * minutes * share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_shared_by_what_is_run() {
        let parse = |arguments: &[&str]| {
            Options::try_parse_from(std::iter::once(&"organs").chain(arguments)).unwrap()
        };
        let options = parse(&["--only", "liver,twisting-cube", "--budget", "10m"]);
        let wanted = ORGANS.iter().filter(|organ| options.wants(organ.key));
        let seconds: f64 = wanted.map(|organ| options.seconds(organ.minutes)).sum();
        assert!((seconds - 600.0).abs() < 1e-9, "{seconds}");
        let error =
            Options::try_parse_from(["organs", "--only", "kidney"]).unwrap_err().to_string();
        assert!(error.contains("twisting-cube"), "{error}");
    }
}
