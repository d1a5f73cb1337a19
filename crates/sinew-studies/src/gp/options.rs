//! Command line.

use crate::gp::experiments::Name;
use clap::Parser;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Repeat the thesis' experiments with Gaussian processes and networks that satisfy boundary conditions exactly
/// (§4.8), and its first physics-informed network (§1.7.3), beside the figures it prints.
#[derive(Parser, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[command(name = "cargo xtask reproduce-gp", version, max_term_width = 110)]
pub struct Options {
    /// Experiments to run, separated by commas [default: all]
    #[arg(long, value_enum, value_delimiter = ',')]
    pub only: Vec<Name>,
    /// Same code with one data set, few starts and steps, within half a minute: a check, not a result
    #[arg(long)]
    pub quick: bool,
    /// Seed that all seeds of the run derive from
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Data sets behind every median [default: 10, or 1 with --quick]
    #[arg(long, value_parser = parse_count)]
    pub seeds: Option<usize>,
    /// Number of fits at the same time, each on one thread [default: number of processors]
    #[arg(long, value_parser = parse_count)]
    #[serde(skip)]
    pub threads: Option<usize>,
    /// Folder for the report and the results of single fits
    #[arg(long, default_value = "out/reproduce-gp")]
    pub out: PathBuf,
    /// Keep the fits in the output folder, and run the missing ones
    #[arg(long)]
    #[serde(skip)]
    pub resume: bool,
}

impl Options {
    /// Data sets behind every median.
    pub(crate) fn seeds(&self) -> usize {
        self.seeds.unwrap_or(if self.quick { 1 } else { 10 })
    }

    /// Fits side by side.
    pub(crate) fn threads(&self) -> usize {
        self.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from))
    }
}

fn parse_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if count > 0 => Ok(count),
        _ => Err(format!("`{text}` is not a count: write a whole number from 1 on")),
    }
}
