//! Tasks of the workspace: `cargo xtask --help`.
//!
//! Studies run as programs of their own crates: this one only builds and starts them, so
//! that `cargo xtask ci` needs none of their dependencies.

mod arrows;
mod browser;
mod ci;
mod circles;
mod command;
mod imports;
mod licences;
mod package;
mod page;
mod readme;
mod stand_in;
mod steps;
mod viewer;
mod walks;
mod wheel;
mod words;

use anyhow::{Context, Result, ensure};
use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "Tasks of the Sinew workspace", after_help = STUDIES)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Measure the coverage of 95 % intervals of Gaussian processes on twenty problems, none of them of the thesis: number of
    /// data sets or `FIRST..END`, `--only NAME,…`, `--evidence joint|unit`, `--points N`
    Coverage {
        /// Options of the program
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        options: Vec<String>,
    },
    /// Format, lints, documentation, dependency arrows, circles of imports, walks and tests: what continuous integration runs
    Ci,
    /// Compare the crates' dependencies with the table in docs/architecture.md, and find tests that never run
    Arrows,
    /// Find words and sentences that the style guide replaces
    Words,
    /// Find circles of imports of more than two files inside a crate
    Circles,
    /// Follow the walks of docs/architecture.md through the code: every room exists and is named by the one before
    Walks,
    /// Build the Python wheel into target/wheel/dist and run its README in a clean virtual environment
    Wheel {
        /// Run the Python tests instead, on a library that is compiled as the workspace's tests are; skipped with a word where Python or its
        /// packages are missing
        #[arg(long)]
        test: bool,
        /// Features of the wheel; `networks` trains graph networks
        #[arg(long, conflicts_with = "test")]
        features: Option<String>,
    },
    /// Run a campaign on a Slurm of two nodes that it starts on this machine; not run, with a word, where it is missing
    Campaigns,
    /// Pack all published crates, and build and test sinew-mesh and sinew-fem from their packages outside of the repository
    Package,
    /// Print the licences of all linked crates; fails on a licence that is not allowed
    Licences,
    /// Write the README of every published crate: the beginning of its documentation
    Readmes,
    /// Open reports and pages of emulators in a headless Chromium: errors, overlapping labels, contrast, in light and dark; sliders, keys and
    /// times of emulators
    Page {
        /// Files such as out/reproduce-beam/report.html, or the address of a page that `sinew serve` prints
        pages: Vec<std::path::PathBuf>,
    },
    /// Run the benchmarks; each prints its error beside its time
    Bench {
        /// Options of criterion, such as a filter on benchmark names
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        options: Vec<String>,
    },
    #[command(external_subcommand)]
    Study(Vec<String>),
}

/// Tasks of `sinew-studies`, told by the help.
const STUDIES: &str = include_str!("studies.txt");

fn main() -> Result<()> {
    if std::env::var_os(stand_in::STANDS_IN).is_some() {
        std::process::exit(i32::from(!stand_in::stand_in()?));
    }
    match Arguments::parse().task {
        Task::Study(words) => study(&words),
        Task::Coverage { options } => command::coverage(&options),
        Task::Ci => ci::run(),
        Task::Arrows => arrows::check(),
        Task::Words => words::check(),
        Task::Circles => circles::check(),
        Task::Walks => walks::check(),
        Task::Wheel { test: false, features } => wheel::run(features.as_deref()),
        Task::Wheel { test: true, .. } => wheel::test(),
        Task::Campaigns => command::campaigns(&[]),
        Task::Package => package::run(),
        Task::Licences => licences::check(),
        Task::Readmes => readme::write(),
        Task::Page { pages } => page::check(&pages),
        Task::Bench { options } => command::benches(&options),
    }
}

/// Runs a study, whose own options follow its name.
fn study(words: &[String]) -> Result<()> {
    let (task, options) = words.split_first().context("no task is named")?;
    let known = STUDIES.lines().any(|line| line.split_whitespace().next() == Some(task.as_str()));
    ensure!(known, "there is no task `{task}`; `cargo xtask --help` lists them");
    command::study(task, options)
}
