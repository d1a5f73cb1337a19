//! One emulator for a population of shapes: `sinew-populations --help`.

use clap::Parser;
use sinew_study::populations::options::Options;
use std::process::ExitCode;

fn main() -> ExitCode {
    sinew_study::program::end(sinew_study::populations::run::reproduce(&Options::parse()))
}
