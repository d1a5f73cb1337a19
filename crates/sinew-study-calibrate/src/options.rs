//! Command line.

use clap::{Parser, ValueEnum};
use std::path::PathBuf;

/// Calibrate synthetic patients: coverage of intervals, and distance from brute force.
#[derive(Parser, Clone, Debug)]
#[command(name = "cargo xtask reproduce-calibration", version, max_term_width = 110)]
pub(crate) struct Options {
    /// Same code on three patients and a coarse grid: a check, not a result
    #[arg(long)]
    pub quick: bool,
    /// Patients of the coverage study
    #[arg(long, default_value_t = 20)]
    pub patients: usize,
    /// Parts to run [default: all]
    #[arg(long, value_delimiter = ',')]
    pub only: Vec<Part>,
    /// Seed that all seeds of the run derive from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for the report
    #[arg(long, default_value = "out/reproduce-calibration")]
    pub out: PathBuf,
}

/// A part of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Part {
    /// Two parameters against a grid of solves, with a bad emulator beside, and adaptive Metropolis.
    Exactness,
    /// Intervals of patients that nothing was tuned for.
    Coverage,
}

impl Options {
    pub(crate) fn wants(&self, part: Part) -> bool {
        self.only.is_empty() || self.only.contains(&part)
    }
}
