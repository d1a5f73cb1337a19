//! Coverage of error estimates: `sinew-coverage --help`.

use clap::Parser;
use sinew_study::coverage::{Options, run};
use std::process::ExitCode;

fn main() -> ExitCode {
    sinew_study::program::end(run(&Options::parse()))
}
