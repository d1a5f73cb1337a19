//! Data of patients that do not exist.

use super::Usage;
use anyhow::{Context, Result};
use clap::Args;
use sinew::{PatientFile, parse_theta};
use std::path::{Path, PathBuf};

/// Patient file and true parameters.
#[derive(Debug, Args)]
#[command(after_help = "\
The entries of [[data]] in PATIENT need a phase, a unit and a standard deviation; their values are made. Pressures are taken as exact.

Example: sinew synthesise patient.toml --theta a=0.2,b=2,a_f=2.8,b_f=2.1 -o made.toml")]
pub(crate) struct Synthesise {
    /// Patient file
    patient: PathBuf,
    /// Parameters, such as a=0.2,b=2
    #[arg(long)]
    theta: String,
    /// Seed of the noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// File to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

impl Synthesise {
    pub(crate) fn run(&self) -> Result<()> {
        let file = PatientFile::read(&self.patient)?;
        let theta = parse_theta(&self.theta, &file.parameters()?)?;
        let text = file.synthesise(&theta, self.seed)?;
        if self.output.exists() && same(&self.output, &self.patient) {
            return Err(Usage("-o: this is the patient file itself; name another".into()).into());
        }
        std::fs::write(&self.output, text).with_context(|| self.output.display().to_string())?;
        println!("written: {}", self.output.display());
        Ok(())
    }
}

fn same(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
