//! The thesis' experiments with Gaussian processes: `sinew-study-gp --help`.

use clap::Parser;
use sinew_study_gp::options::Options;
use std::process::ExitCode;

fn main() -> ExitCode {
    sinew_study::program::end(sinew_study_gp::reproduce_gp(&Options::parse()))
}
