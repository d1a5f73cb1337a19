//! Benchmarks of the solver: `cargo xtask verify --help`.

use clap::Parser;
use sinew_verify::{Options, cases, verify};
use std::process::ExitCode;

fn main() -> ExitCode {
    match verify(&cases::ALL, &Options::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("\nerror: {error:#}");
            ExitCode::FAILURE
        }
    }
}
