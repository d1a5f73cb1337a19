//! Data of patients that do not exist.

use super::{Usage, check_folder, keep_foreign, marked, refuse_if, same, warn, write};
use anyhow::Result;
use clap::Args;
use sinew::{Parameter, PatientFile, admissible, outside, parse_theta};
use std::path::PathBuf;

/// Beginning of the files that the command writes.
const MARK: &str = "# synthesised from ";

/// Patient file and true parameters.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/synthesise.txt"))]
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
    #[arg(short, long, visible_alias = "out", value_name = "FILE")]
    output: PathBuf,
}

impl Synthesise {
    pub(crate) fn run(&self) -> Result<()> {
        check_folder(&self.output)?;
        let file = PatientFile::read(&self.patient)?;
        refuse_if(
            same(&self.output, &self.patient),
            || "-o: this is the patient file itself; name another",
        )?;
        keep_foreign("synthesise", MARK, &self.output)?;
        let parameters = file.parameters()?;
        let theta = parse_theta(&self.theta, &parameters)?;
        self.check(&file, &parameters, &theta)?;
        let text = file.synthesise(&theta, self.seed)?;
        let origin =
            format!("{}, theta {}, seed {}", self.patient.display(), self.theta, self.seed);
        write(&self.output, marked(MARK, &origin, &text))?;
        println!("written: {}", self.output.display());
        Ok(())
    }

    /// Refuses parameters that make no sense, and tells those outside their ranges on standard error.
    fn check(&self, file: &PatientFile, parameters: &[Parameter], theta: &[f64]) -> Result<()> {
        let body = file.case.body()?;
        let value = |own: &Parameter| {
            let place = parameters.iter().position(|unknown| unknown.name == own.name);
            place.map_or(own.range[0], |place| theta[place])
        };
        let all: Vec<f64> = body.parameters.iter().map(value).collect();
        admissible(&body, &all).map_err(|why| Usage(format!("--theta {}: {why}", self.theta)))?;
        warn(outside(parameters, theta));
        Ok(())
    }
}
