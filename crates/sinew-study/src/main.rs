//! Studies of soft-tissue emulators: `sinew-study --help`.

use clap::Parser;
use sinew_study::options::{Options, Study};
use std::process::ExitCode;

fn main() -> ExitCode {
    let result = match Options::parse().study {
        Study::ReproduceBeam(options) => sinew_study::run::reproduce_beam(&options),
        Study::ReproduceGp(options) => sinew_study::gaussian::reproduce_gp(&options),
    };
    match result {
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
