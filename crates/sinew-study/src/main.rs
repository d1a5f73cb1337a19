//! Emulators of the thesis' beams: `sinew-study --help`.

use clap::Parser;
use sinew_study::options::BeamOptions;
use std::process::ExitCode;

fn main() -> ExitCode {
    match sinew_study::run::reproduce_beam(&BeamOptions::parse()) {
        Ok(report) => {
            eprintln!("\nreport: {}", report.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("\nerror: {error:#}");
            ExitCode::FAILURE
        }
    }
}
