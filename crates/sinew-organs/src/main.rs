//! Emulators of the thesis' organs: `sinew-organs --help`.

use clap::Parser;
use sinew_organs::options::Options;
use std::process::ExitCode;

fn main() -> ExitCode {
    sinew_study::program::end(sinew_organs::reproduce::reproduce(&Options::parse()))
}
