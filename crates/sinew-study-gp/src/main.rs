//! The thesis' experiments with Gaussian processes: `sinew-study-gp --help`.

use clap::Parser;
use sinew_study_gp::options::Options;
use std::process::ExitCode;

fn main() -> ExitCode {
    match sinew_study_gp::reproduce_gp(&Options::parse()) {
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
