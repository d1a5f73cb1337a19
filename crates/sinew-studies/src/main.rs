//! All studies as one program, each a task of `cargo xtask`: `sinew-studies --help`.

use clap::{Parser, Subcommand};
use sinew_studies::beams::options::BeamOptions;
use sinew_studies::measure::Measurement;
use sinew_studies::program::end;
use sinew_studies::{beams, calibration, coverage, gp, organs, populations, thesis, verify};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "cargo xtask", version, max_term_width = 110)]
struct Program {
    #[command(subcommand)]
    study: Study,
}

#[derive(Subcommand)]
enum Study {
    ReproduceBeam(BeamOptions),
    ReproduceOrgans(organs::options::Options),
    ReproducePopulations(populations::options::Options),
    ReproduceGp(gp::Options),
    ReproduceCalibration(calibration::options::Options),
    CoverageEstimates(coverage::Options),
    Thesis(thesis::run::Options),
    Verify(verify::Options),
    /// Repeat a measurement that documents cite
    #[command(subcommand)]
    Measure(Measurement),
}

fn main() -> ExitCode {
    sinew::free_at_once();
    match Program::parse().study {
        Study::ReproduceBeam(options) => end(beams::run::reproduce_beam(&options)),
        Study::ReproduceOrgans(options) => end(organs::reproduce::reproduce(&options)),
        Study::ReproducePopulations(options) => end(populations::run::reproduce(&options)),
        Study::ReproduceGp(options) => end(gp::reproduce_gp(&options)),
        Study::ReproduceCalibration(options) => end(calibration::reproduce(&options)),
        Study::CoverageEstimates(options) => end(coverage::run(&options)),
        Study::Thesis(options) => end(thesis::run::reproduce(&options)),
        Study::Verify(options) => passed(verify::verify(&verify::cases::ALL, &options)),
        Study::Measure(measurement) => passed(measurement.run().map(|()| true)),
    }
}

fn passed(result: anyhow::Result<bool>) -> ExitCode {
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => end(Err(error)),
    }
}
