//! Every figure of the thesis beside ours: `sinew-thesis --help`.

use clap::Parser;
use sinew_study::thesis::run::{Options, reproduce};
use std::process::ExitCode;

fn main() -> ExitCode {
    match reproduce(&Options::parse()) {
        Ok(page) => {
            eprintln!("\npage: {}", page.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("\nerror: {error:#}");
            ExitCode::FAILURE
        }
    }
}
