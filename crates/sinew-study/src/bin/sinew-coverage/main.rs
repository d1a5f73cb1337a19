//! Coverage of error estimates, and measurements: `sinew-coverage --help`, `sinew-coverage measure --help`.

mod measure;

use clap::{Parser, Subcommand};
use measure::Measurement;
use sinew_study::coverage::{Options, run};
use sinew_study::program::end;
use std::process::ExitCode;

#[derive(Parser)]
#[command(
    name = "cargo xtask coverage-estimates",
    version,
    max_term_width = 110,
    args_conflicts_with_subcommands = true
)]
struct Program {
    #[command(flatten)]
    options: Options,
    #[command(subcommand)]
    task: Option<Task>,
}

#[derive(Subcommand)]
enum Task {
    /// Measurements of emulators and patients that documents cite
    #[command(subcommand)]
    Measure(Measurement),
}

fn main() -> ExitCode {
    let Program { options, task } = Program::parse();
    let Some(Task::Measure(measurement)) = task else { return end(run(&options)) };
    match measurement.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => end(Err(error)),
    }
}
