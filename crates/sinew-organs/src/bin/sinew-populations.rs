//! One emulator for a population of shapes: `sinew-populations --help`.

use clap::Parser;
use sinew_organs::populations::options::Options;
use std::process::ExitCode;

fn main() -> ExitCode {
    sinew_study::program::end(sinew_organs::populations::run::reproduce(&Options::parse()))
}
