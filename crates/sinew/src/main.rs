//! The program `sinew`: from a case file to fields, emulators, predictions and their errors.

#[macro_use]
mod print;
mod commands;

use clap::builder::ArgPredicate;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use commands::{
    calibrate, evaluate, export, mesh, predict, sample, scenes, serve, solve, train, unload,
};
use std::process::ExitCode;

/// Physics-informed emulation of soft-tissue mechanics: solve, train, predict and correct bodies from case files.
#[derive(Debug, Parser)]
#[command(name = "sinew", version, after_help = include_str!("commands/help/sinew.txt"), max_term_width = 110)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make a mesh from surfaces.
    #[command(subcommand)]
    Mesh(mesh::Mesh),
    /// Find equilibria by Newton's method.
    Solve(solve::Solve),
    /// Find the reference configuration of a body whose mesh shows the loaded state.
    Unload(unload::UnloadCommand),
    /// Infer a patient's parameters from an image, pressures and measurements.
    Calibrate(calibrate::Calibrate),
    /// Make the data of a patient file from parameters, with noise.
    Synthesise(calibrate::Synthesise),
    /// Sample parameter sets from their ranges, and solve them with --solve.
    Sample(sample::Sample),
    /// Merge the shards of a campaign.
    Merge(sample::Merge),
    /// Train an emulator.
    Train(Box<train::Train>),
    /// Estimate the cost of answers to an accuracy, by each method.
    Plan(predict::Plan),
    /// Predict displacements, with a trained emulator or to an accuracy.
    Predict(predict::Predict),
    /// Predict, and correct the prediction by Newton steps.
    Correct(predict::Correct),
    /// Measure errors and times of the trained emulators on unseen cases.
    Evaluate(evaluate::Evaluate),
    /// Write the emulator as a page for a browser, or the weights of a network.
    Export(export::Export),
    /// Answer samplers and other programs over HTTP, by UM-Bridge.
    Serve(serve::Serve),
    /// List built-in scenes and laws.
    Scenes,
    /// Print the case file of a built-in scene.
    New(scenes::New),
}

/// Options whose numbers may be written as clap knows none with a minus: -1e-3, -5s.
const NUMBERS: [&str; 5] = ["accuracy", "budget", "edge", "minutes", "target"];

/// A command that takes what begins with a minus after an option for its value, to be refused with the option's name.
fn signed(command: clap::Command) -> clap::Command {
    let number = |option: clap::Arg| match NUMBERS.contains(&option.get_id().as_str()) {
        true => option.allow_hyphen_values(true),
        false => option,
    };
    command.allow_negative_numbers(true).mut_args(number).mut_subcommands(signed)
}

/// The command that needs no case where runs of another solver are given.
fn with_runs(train: clap::Command) -> clap::Command {
    const RUNS: [&str; 2] = ["from_table", "from_fields"];
    // What stands there is not read.
    let spare = RUNS.map(|option| (option, ArgPredicate::IsPresent, "."));
    let case = |case: clap::Arg| {
        case.required(false).required_unless_present_any(RUNS).default_value_ifs(spare)
    };
    train.mut_arg("case", case)
}

fn main() -> ExitCode {
    sinew::free_at_once();
    let program = Arguments::command().mut_subcommands(signed);
    let program = program.mut_subcommand("train", with_runs);
    let arguments = Arguments::from_arg_matches(&program.get_matches());
    let done = match arguments.unwrap_or_else(|error| error.exit()).command {
        Command::Mesh(command) => command.run(),
        Command::Solve(command) => command.run(),
        Command::Unload(command) => command.run(),
        Command::Calibrate(command) => command.run(),
        Command::Synthesise(command) => command.run(),
        Command::Sample(command) => command.run(),
        Command::Merge(command) => command.run(),
        Command::Train(command) => command.run(),
        Command::Plan(command) => command.run(),
        Command::Predict(command) => command.run(),
        Command::Correct(command) => command.run(),
        Command::Evaluate(command) => command.run(),
        Command::Export(command) => command.run(),
        Command::Serve(command) => command.run(),
        Command::Scenes => scenes::list(),
        Command::New(command) => command.run(),
    };
    match done {
        Ok(()) => match print::lost() {
            None => ExitCode::SUCCESS,
            Some(reason) => {
                eprintln!("error: standard output is incomplete: {reason}");
                ExitCode::FAILURE
            }
        },
        Err(error) => {
            eprintln!("error: {}", commands::told(&error));
            ExitCode::from(commands::code(&error))
        }
    }
}
