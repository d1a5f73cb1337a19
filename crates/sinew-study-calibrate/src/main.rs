//! Posteriors of synthetic patients: `sinew-study-calibrate --help`.

mod coverage;
mod exactness;
mod metropolis;
mod options;
mod patients;

use anyhow::Result;
use clap::Parser;
use options::{Options, Part};
use sinew_report::{Provenance, Report};
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<()> {
    let clock = Instant::now();
    let provenance =
        Provenance::of_this_run("cargo xtask reproduce-calibration", env!("CARGO_MANIFEST_DIR"));
    let mut report = Report::new(
        "Calibration",
        "posteriors of synthetic patients against truth and brute force",
        provenance,
    );
    if options.wants(Part::Exactness) {
        report.sections.extend(exactness::sections(options)?);
    }
    if options.wants(Part::Coverage) {
        report.sections.push(coverage::section(options)?);
    }
    report.provenance = report.provenance.clone().finished(clock.elapsed().as_secs_f64());
    report.provenance.seed = Some(options.seed);
    println!("written: {}", report.write(&options.out)?.display());
    Ok(())
}
