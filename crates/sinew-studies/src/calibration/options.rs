//! Command line.

use clap::{Parser, ValueEnum};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Calibrate synthetic patients: coverage of intervals, and distance from brute force.
#[derive(Parser, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[command(name = "cargo xtask reproduce-calibration", version, max_term_width = 110)]
pub struct Options {
    /// Same code on three patients and coarse grids: a check, not a result
    #[arg(long)]
    pub quick: bool,
    /// Patients of the coverage study; the study of springs has a quarter of them for each of its four pairs of truth and model
    #[arg(long, default_value_t = 100)]
    pub patients: usize,
    /// Parts to run [default: all]
    #[arg(long, value_delimiter = ',')]
    pub only: Vec<Part>,
    /// Seed that all seeds of the run derive from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for the report and stored results
    #[arg(long, default_value = "out/reproduce-calibration")]
    pub out: PathBuf,
    /// Keep the finished patients of an earlier run with the same options
    #[arg(long)]
    #[serde(skip)]
    pub resume: bool,
}

/// A part of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Part {
    /// Two parameters against a grid of solves, also with a poor emulator, and adaptive Metropolis.
    Grid,
    /// Four parameters against importance sampling.
    Importance,
    /// Intervals of patients that nothing was tuned for.
    Coverage,
    /// Intervals and doubts of models with springs that the patient lacks, or without those that it has.
    Springs,
}

impl Options {
    /// Whether a part is asked for.
    pub fn wants(&self, part: Part) -> bool {
        self.only.is_empty() || self.only.contains(&part)
    }
}
