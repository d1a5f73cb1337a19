//! Posteriors of synthetic patients: `sinew-calibration --help`.

use clap::Parser;
use sinew_study::calibration::{options::Options, reproduce};
use std::process::ExitCode;

fn main() -> ExitCode {
    sinew_study::program::end(reproduce(&Options::parse()))
}
