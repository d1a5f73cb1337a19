//! Options and parts of the study, and rows of its listings.

use clap::{Parser, ValueEnum};
use serde::{Deserialize, Serialize};
use sinew_report::{Block, Cell};
use std::path::PathBuf;

/// Calibrate synthetic patients: coverage of intervals, and distance from brute force.
#[derive(Parser, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[command(name = "cargo xtask reproduce-calibration", version, max_term_width = 110)]
pub struct Options {
    /// Same code on three patients and few draws: a check, not a result
    #[arg(long)]
    pub quick: bool,
    /// Patients of the coverage study
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
    /// Four parameters against importance sampling.
    Importance,
    /// Intervals of patients that nothing was tuned for.
    Coverage,
}

impl Options {
    /// Whether a part is asked for.
    pub fn wants(&self, part: Part) -> bool {
        self.only.is_empty() || self.only.contains(&part)
    }
}

/// A row of a listing, which is printed too.
pub(super) fn row(name: &str, head: &[&str], numbers: &[f64]) -> Vec<Cell> {
    let said = head.iter().zip(numbers).filter(|(_, number)| !number.is_nan());
    let said: Vec<String> = said.map(|(head, number)| format!("{head} {number:.3}")).collect();
    println!("{name}: {}", said.join(", "));
    let cell = |number: &f64| if number.is_nan() { Cell::default() } else { Cell::from(*number) };
    std::iter::once(Cell::from(name)).chain(numbers.iter().map(cell)).collect()
}

/// A listing whose rows have a name and a number under each of some heads.
pub(super) fn listing(
    title: impl Into<String>,
    first: &str,
    names: &[&str],
    rows: Vec<Vec<Cell>>,
) -> Block {
    Block::listing(title, std::iter::once(first).chain(names.iter().copied()), rows)
}
