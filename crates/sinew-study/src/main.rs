//! Emulators of the thesis' beams: `sinew-study --help`.

use clap::Parser;
use sinew_study::beams::options::BeamOptions;
use std::process::ExitCode;

fn main() -> ExitCode {
    sinew_study::program::end(sinew_study::beams::run::reproduce_beam(&BeamOptions::parse()))
}
