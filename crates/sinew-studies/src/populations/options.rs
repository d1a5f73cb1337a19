//! Command line.

use super::stage;
use crate::program;
use clap::Parser;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Measure methods on unseen shapes against the solver: a frozen stiffness, Taylor expansions, regression on simulations of registered
/// shapes, and the networks of the thesis' chapter 2.
#[derive(Parser, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[command(name = "cargo xtask reproduce-populations", version, max_term_width = 110)]
pub struct Options {
    /// Populations, separated by commas [default: all]
    #[arg(long, value_delimiter = ',', value_parser = keys())]
    pub only: Vec<String>,
    /// Same code on small meshes with few shapes and steps: a check, not a result
    #[arg(long)]
    pub quick: bool,
    /// The ventricles of chapter 2 on a mesh like the thesis', 6788 nodes: hours
    #[arg(long, conflicts_with = "quick")]
    #[serde(default)]
    pub full: bool,
    /// Leave out regressions on simulations
    #[arg(long)]
    #[serde(default)]
    pub no_rivals: bool,
    /// Leave out networks on the ventricles of chapter 2: regressions and the coarse solution only
    #[arg(long)]
    #[serde(default)]
    pub no_networks: bool,
    /// Networks of plane beams on the graph of a template instead of the average beam (Tables A.5 to A.7)
    #[arg(long)]
    #[serde(default)]
    pub template: bool,
    /// Learn from the first of the simulations of the ventricles of chapter 2 only
    #[arg(long, value_name = "COUNT", conflicts_with = "quick", value_parser = clap::value_parser!(u64).range(8..=850))]
    #[serde(default)]
    pub simulations: Option<u64>,
    /// Folder with surfaces of a real heart, such as patient1_LV_ENDOCARDIAL_000.vtk; optional
    #[arg(long, default_value = "../shared/meshes/biv-me")]
    pub hearts: PathBuf,
    /// Seed that all seeds of the run derive from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Number of seeds, from --seed upwards; medians of all seeds stand beside each other
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    #[serde(default = "one")]
    pub seeds: u64,
    /// Folder for the report and stored results
    #[arg(long, default_value = "out/reproduce-populations")]
    pub out: PathBuf,
    /// Keep the populations that an earlier run with the same options has finished
    #[arg(long)]
    #[serde(skip)]
    pub resume: bool,
}

/// Names of all parts of the study, in their order.
pub fn keys() -> Vec<&'static str> {
    [stage::RECTANGLES, stage::INFLATED, stage::SPEED].into_iter().chain(stage::KEYS).collect()
}

fn one() -> u64 {
    1
}

/// Results of a population's study, with the options of its run.
#[derive(Serialize, Deserialize)]
struct Kept<S> {
    options: Options,
    #[serde(flatten)]
    study: S,
}

impl Options {
    /// Options with each of its seeds.
    pub(super) fn of_each_seed(&self) -> impl Iterator<Item = Self> {
        let of = |k| Self { seed: self.seed.wrapping_add(k), seeds: 1, ..self.clone() };
        (0..self.seeds).map(of)
    }

    /// Studies a population with each seed, or reads what an earlier run has found where this one goes on.
    pub(super) fn study<S: Serialize + DeserializeOwned>(
        &self,
        key: &str,
        study: impl Fn(&Self) -> anyhow::Result<S>,
    ) -> anyhow::Result<Vec<S>> {
        let one = |options: Self| {
            let name = match options.seed == self.seed {
                true => "study.json".into(),
                false => format!("study-seed-{}.json", options.seed),
            };
            let file = self.out.join(key).join(name);
            options.kept(&file, || study(&options))
        };
        self.of_each_seed().map(one).collect()
    }

    /// A part of the study in a file, read from where a run with the same options that goes on has left it.
    pub(super) fn kept<S: Serialize + DeserializeOwned>(
        &self,
        file: &Path,
        make: impl FnOnce() -> anyhow::Result<S>,
    ) -> anyhow::Result<S> {
        let kept: Kept<S> = program::kept(file, self.resume, || {
            Ok(Kept { study: make()?, options: self.clone() })
        })?;
        program::same_options(&kept.options, self, file)?;
        Ok(kept.study)
    }
}
