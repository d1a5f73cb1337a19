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
mod miri;
mod package;
mod page;
mod readme;
mod stand_in;
mod steps;
mod viewer;
mod walks;
mod wheel;
mod words;

use anyhow::Result;
use clap::{Args, Parser, Subcommand};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "Tasks of the Sinew workspace")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

/// Arguments handed on to a program, `--help` included.
#[derive(Args)]
#[command(disable_help_flag = true)]
struct Options {
    /// Options of the program; `--help` lists them
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    options: Vec<String>,
}

#[derive(Subcommand)]
enum Task {
    /// Compare data-driven and physics-informed emulators of the thesis' two gravity beams with
    /// the finite-element solver, from the mesh to the report
    ReproduceBeam(Options),
    /// Train emulators of the thesis' organs and measure them against the finite-element solver, on their own meshes and on
    /// meshes and shapes they were not trained on
    ReproduceOrgans(Options),
    /// Measure methods on unseen shapes against the solver: a frozen stiffness, Taylor expansions, regression, and the thesis' networks
    ReproducePopulations(Options),
    /// Repeat the thesis' experiments with Gaussian processes and networks that satisfy boundary
    /// conditions exactly, beside the figures it prints
    ReproduceGp(Options),
    /// Compare every figure that the thesis prints with ours: run the studies that are missing and write docs/thesis.md
    Thesis(Options),
    /// Calibrate synthetic patients: coverage of intervals, and distance of posteriors from brute force
    ReproduceCalibration(Options),
    /// Measure the coverage of 95 % intervals of Gaussian processes on twenty problems, none of them of the thesis: number of
    /// data sets or `FIRST..END`, `--only NAME,…`, `--evidence joint|unit`, `--points N`
    Coverage(Options),
    /// Compare error estimates of emulators with true errors, on bodies and ranges that nothing was tuned for
    CoverageEstimates(Options),
    /// Run the benchmarks of the solver, against references that share no code with it
    Verify(Options),
    /// Repeat a measurement that documents cite; `--help` lists them
    Measure(Options),
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
    /// Run a campaign on a Slurm of two nodes that it starts on this machine, and one by Snakemake; not run, with a word, where these
    /// are missing
    Campaigns,
    /// Pack all published crates, and build and test sinew-mesh and sinew-fem from their packages outside of the repository
    Package,
    /// Print the licences of all linked crates; fails on a licence that is not allowed
    Licences,
    /// Write the README of every published crate: the beginning of its documentation
    Readmes,
    /// Run the tests of the matrix product, whose code is unsafe, under Miri on the nightly toolchain
    Miri,
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
}

fn main() -> Result<()> {
    if std::env::var_os(stand_in::STANDS_IN).is_some() {
        std::process::exit(i32::from(!stand_in::stand_in()?));
    }
    let study = |task: &str, of: Options| command::study(task, &of.options);
    match Arguments::parse().task {
        Task::ReproduceBeam(options) => study("reproduce-beam", options),
        Task::ReproduceOrgans(options) => study("reproduce-organs", options),
        Task::ReproducePopulations(options) => study("reproduce-populations", options),
        Task::ReproduceGp(options) => study("reproduce-gp", options),
        Task::Thesis(options) => study("thesis", options),
        Task::ReproduceCalibration(options) => study("reproduce-calibration", options),
        Task::Coverage(Options { options }) => command::coverage(&options),
        Task::CoverageEstimates(options) => study("coverage-estimates", options),
        Task::Verify(options) => study("verify", options),
        Task::Measure(options) => study("measure", options),
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
        Task::Miri => miri::run(),
        Task::Page { pages } => page::check(&pages),
        Task::Bench { options } => command::benches(&options),
    }
}
