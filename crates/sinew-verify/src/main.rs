//! Benchmarks of the solver, and measurements: `cargo xtask verify --help`, `cargo xtask measure --help`.

mod measure;

use clap::{Parser, Subcommand};
use measure::Measurement;
use sinew_verify::{Options, cases, verify};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "cargo xtask verify", version, args_conflicts_with_subcommands = true)]
struct Program {
    #[command(flatten)]
    options: Options,
    #[command(subcommand)]
    task: Option<Task>,
}

#[derive(Subcommand)]
enum Task {
    /// Measurements that documents cite; those of emulators and patients are anchors, by-size and patient-cost, which `cargo xtask measure` builds
    /// with the studies
    #[command(subcommand)]
    Measure(Measurement),
}

fn main() -> ExitCode {
    let Program { options, task } = Program::parse();
    let done = match task {
        Some(Task::Measure(measurement)) => measurement.run().map(|()| true),
        None => verify(&cases::ALL, &options),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("\nerror: {error:#}");
            ExitCode::FAILURE
        }
    }
}
