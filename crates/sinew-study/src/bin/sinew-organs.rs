//! Emulators of the thesis' organs: `sinew-organs --help`.

use clap::Parser;
use sinew_study::organs::options::Options;
use std::process::ExitCode;

fn main() -> ExitCode {
    sinew_study::program::end(sinew_study::organs::reproduce::reproduce(&Options::parse()))
}
