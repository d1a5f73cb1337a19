//! Posteriors of a patient's parameters, and data of patients that do not exist.

use super::runs::DataFile;
use super::{
    CaseArguments, Unpassed, Usage, check_folder, keep, keep_foreign, marked, refuse_if, same,
    tell_reading, warn, write,
};
use anyhow::Result;
use clap::Args;
use sinew::calibration::{ahead_in_words, in_words, kept, setting_in_words, too_stiff, written};
use sinew::{Case, Parameter, PatientFile, admissible, outside, parse_theta};
use sinew_calibrate::{CalibrateError, Solves, Verdict, calibrate, check_identifiability};
use sinew_emulate::Terminal;
use sinew_report::Provenance;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Patient file and folder.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/calibrate.txt"))]
pub(crate) struct Calibrate {
    #[command(flatten)]
    patient: CaseArguments,
    /// Say first whether the model calibrates the data (exit code 0), does not (4), or that they cannot tell (5); then what they identify,
    /// with units, phases and segments as they were read; and stop before sampling
    #[arg(long)]
    check: bool,
    /// Stop with an error when this time is over, such as 60s or 5m
    #[arg(long, value_name = "TIME", value_parser = duration)]
    budget: Option<Duration>,
    /// Continue a run that was stopped, from its stored solves
    #[arg(long, conflicts_with = "restart")]
    resume: bool,
    /// Start anew where solves of an earlier run are stored
    #[arg(long)]
    restart: bool,
    /// Seed [default: that of the file]
    #[arg(long)]
    seed: Option<u64>,
}

fn duration(text: &str) -> Result<Duration, String> {
    let end = text.find(|c: char| c.is_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let size = match unit.trim() {
        "" | "s" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(format!("`{unit}` is not a unit of time; write 60s, 5m or 1h")),
    };
    let value = number.trim().parse::<f64>().ok();
    let time = value.and_then(|value| Duration::try_from_secs_f64(value * size).ok());
    time.ok_or_else(|| format!("`{text}` is not a time, such as 60s"))
}

impl Calibrate {
    pub(crate) fn run(&self) -> Result<()> {
        if let Some(file) = DataFile::read(&self.patient.file.case)? {
            let solver = self.check || self.resume || self.restart || self.budget.is_some();
            let reason = "--check, --resume, --restart, --budget and --mesh are for patients, who have a solver; leave them out";
            refuse_if(solver || self.patient.file.mesh.is_some(), || reason)?;
            return file.calibrate(&self.patient, self.seed);
        }
        let clock = Instant::now();
        let (case, folder) = self.patient.read()?;
        let file = PatientFile::of(case)?;
        let prepared = tell_reading(&file.case, file.prepare())?;
        warn(file.case.warnings(&prepared.body));
        warn(prepared.warnings());
        let patient = prepared.patient().map_err(Usage)?;
        let folder = folder.join("calibrate");
        let mut terminal = Terminal::default();
        let mut solves = Solves::new(&patient);
        solves.observer = Some(&mut terminal);
        solves.budget = self.budget;
        if self.check {
            let problem = &prepared.problem;
            let found = check_identifiability(problem, &mut solves);
            let verdict = found.as_ref().ok().map(|(mode, seen)| seen.verdict(problem, mode));
            verdict.iter().for_each(|(_, reason)| println!("{reason}\n"));
            setting_in_words(&prepared).iter().for_each(|line| println!("{line}"));
            let (mode, seen) = found.map_err(told)?;
            ahead_in_words(&prepared, &mode, &seen).iter().for_each(|line| println!("{line}"));
            // The verdict stands even if the warning about cells cannot be given.
            warn(patient.states_checked(&mode.theta, false).iter().flat_map(too_stiff));
            return match verdict.map(|(verdict, _)| verdict) {
                Some(Verdict::DoesNot) => Err(Unpassed(4).into()),
                Some(Verdict::CannotTell) => Err(Unpassed(5).into()),
                _ => Ok(()),
            };
        }
        let again = [self.resume, self.restart];
        let mut solves = kept(solves, &folder, &file, &prepared, again).map_err(told)?;
        let mut options = file.options();
        options.seed = self.seed.unwrap_or(options.seed);
        let posterior = calibrate(&prepared.problem, &mut solves, &options).map_err(told)?;
        let provenance = Provenance::of_this_run("sinew", env!("CARGO_MANIFEST_DIR"));
        let provenance = provenance.finished(clock.elapsed().as_secs_f64());
        let provenance = Provenance { seed: Some(options.seed), ..provenance };
        let (page, doubts) = written(&file, &prepared, &patient, &posterior, provenance, &folder)?;
        warn(doubts);
        in_words(&prepared, &posterior).iter().for_each(|line| println!("{line}"));
        println!("written: {}", page.display());
        Ok(())
    }
}

/// An error of the input is one of the command line.
pub(super) fn told(error: CalibrateError) -> anyhow::Error {
    match error {
        CalibrateError::Input(reason) | CalibrateError::Store(reason) => Usage(reason).into(),
        other => other.into(),
    }
}

/// Beginning of the files of data that are made.
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
        keep([&self.patient].into_iter().chain(&file.case.files()), &self.output)?;
        let folder = |file: &Path| file.parent().unwrap_or(file).join(".");
        let named = Case::parse(file.case.text(), "")?.files();
        let stays = same(&folder(&self.patient), &folder(&self.output));
        refuse_if(!stays && named.iter().any(|file| file.is_relative()), || {
            format!(
                "-o: {} names files by their places beside it; write into its folder",
                self.patient.display()
            )
        })?;
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
