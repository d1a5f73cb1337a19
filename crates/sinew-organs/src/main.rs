//! Emulators of the thesis' organs: `sinew-organs --help`.

use clap::Parser;
use sinew_organs::options::Options;
use std::process::ExitCode;

fn main() -> ExitCode {
    match sinew_organs::run::reproduce(&Options::parse()) {
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
