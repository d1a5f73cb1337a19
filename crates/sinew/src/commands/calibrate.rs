//! Posteriors of a patient's parameters, and data of patients that do not exist.

use super::runs::DataFile;
use super::{
    CaseArguments, Unpassed, Usage, check_folder, keep_foreign, marked, refuse, refuse_if, same,
    tell_reading, warn, write,
};
use anyhow::{Context, Result};
use clap::Args;
use sinew::calibration::{Curve, arviz, in_words, observed, report, too_stiff};
use sinew::case::stress_in_kpa;
use sinew::{Parameter, PatientFile, Prepared, admissible, outside, parse_theta};
use sinew_calibrate::{
    CalibrateError, Identifiability, Mode, Patient, Posterior, Verdict, calibrate,
    check_identifiability, noise_in_words,
};
use sinew_emulate::Terminal;
use sinew_report::Provenance;
use sinew_report::format::{digits, trimmed};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Misfit \[standard deviations\] from which on `--check` marks a datum.
const DOUBTFUL: f64 = 3.0;

/// Solves of a run within its folder.
pub(super) const SOLVES: &str = "solves.csv";
/// Results of a run within its folder.
const RESULTS: [&str; 7] = [
    "posterior.csv",
    "posterior.json",
    "provenance.json",
    "edpvr.csv",
    "rest.vtu",
    "report.html",
    "report.json",
];

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
        let patient = prepared.patient().map_err(Usage)?;
        let folder = folder.join("calibrate");
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let mut terminal = Terminal::default();
        let mut solves = observed(&patient, &mut terminal);
        solves.budget = self.budget;
        if self.check {
            let found = check_identifiability(&prepared.problem, &mut solves);
            let verdict =
                found.as_ref().ok().map(|(mode, seen)| seen.verdict(&prepared.problem, mode));
            verdict.iter().for_each(|(_, reason)| println!("{reason}\n"));
            say_setting(&prepared);
            let (mode, seen) = found.map_err(told)?;
            say_ahead(&prepared, &mode, &seen);
            // The verdict stands even if the warning about cells cannot be given.
            warn(patient.states_checked(&mode.theta, false).iter().flat_map(too_stiff));
            return match verdict.map(|(verdict, _)| verdict) {
                Some(Verdict::DoesNot) => Err(Unpassed(4).into()),
                Some(Verdict::CannotTell) => Err(Unpassed(5).into()),
                _ => Ok(()),
            };
        }
        let stored = folder.join(SOLVES);
        if !self.resume && !self.restart {
            refuse_solved(&stored)?;
        }
        let mut solves =
            solves.kept_in(&stored, &identity(&file, &prepared)?, self.resume).map_err(told)?;
        remove_results(&folder)?;
        let mut options = file.options();
        options.seed = self.seed.unwrap_or(options.seed);
        let posterior = calibrate(&prepared.problem, &mut solves, &options).map_err(told)?;
        self.write(&file, &prepared, &patient, &posterior, &folder, clock)
    }

    fn write(
        &self,
        file: &PatientFile,
        prepared: &Prepared,
        patient: &Patient,
        posterior: &Posterior,
        folder: &Path,
        clock: Instant,
    ) -> Result<()> {
        posterior.write_csv(&folder.join("posterior.csv"))?;
        arviz(prepared, posterior).write(&folder.join("posterior.json"))?;
        let mut curves = Vec::new();
        for (cavity, _) in &prepared.pressures {
            match Curve::new(prepared, posterior, cavity) {
                Ok(curve) => curves.push(curve),
                Err(reason) => eprintln!("warning: no pressure–volume curve: {reason}"),
            }
        }
        if let Some(curve) = curves.first() {
            write(&folder.join("edpvr.csv"), curve.to_csv())?;
        }
        let rest = patient.states_checked(&posterior.mode.theta, false)?;
        warn(too_stiff(&rest));
        if let Some(unloaded) = &rest.unloaded {
            sinew::mesh_at_rest(&prepared.body, unloaded).write_vtu(folder.join("rest.vtu"))?;
        }
        let provenance = Provenance::of_this_run("sinew", env!("CARGO_MANIFEST_DIR"));
        let provenance = Provenance {
            seed: Some(self.seed.unwrap_or(file.options().seed)),
            config: file.case.text().trim_end().into(),
            ..provenance.finished(clock.elapsed().as_secs_f64())
        };
        let name = &file.case.name;
        let page = report(name, prepared, posterior, &curves, &rest, provenance).write(folder)?;
        in_words(prepared, posterior).iter().for_each(|line| println!("{line}"));
        println!("written: {}", page.display());
        Ok(())
    }
}

/// An error of the input is one of the command line.
fn told(error: CalibrateError) -> anyhow::Error {
    match error {
        CalibrateError::Input(reason) | CalibrateError::Store(reason) => Usage(reason).into(),
        other => other.into(),
    }
}

/// Refuses to replace the solves of an earlier run; the first line names its patient.
fn refuse_solved(stored: &Path) -> Result<()> {
    let text = std::fs::read_to_string(stored).unwrap_or_default();
    let count = text.lines().count().saturating_sub(1);
    refuse_if(count > 0, || {
        format!(
            "{} holds {count} solves of an earlier run; --resume goes on from them, --restart starts anew without them",
            stored.display()
        )
    })
}

/// Removes the results of an earlier run, which would stand beside solves of another.
pub(super) fn remove_results(folder: &Path) -> Result<()> {
    for name in RESULTS {
        let path = folder.join(name);
        if let Err(error) = std::fs::remove_file(&path)
            && error.kind() != std::io::ErrorKind::NotFound
        {
            return refuse(format!(
                "{}: the result of an earlier run cannot be removed: {error}; check the permissions",
                path.display()
            ));
        }
    }
    Ok(())
}

/// Hash of the inputs of a solve: the file's settings, whatever their order and comments, and the mesh with its nodes, cells, sets and
/// fields, from which the body follows.
fn identity(file: &PatientFile, prepared: &Prepared) -> Result<String> {
    let mut hash = DefaultHasher::new();
    file.settings()?.hash(&mut hash);
    format!("{:?}", prepared.body.mesh).hash(&mut hash);
    Ok(format!("# solves of a patient, {:016x}", hash.finish()))
}

/// Phases, cavities, segments and data as they were read.
fn say_setting(prepared: &Prepared) {
    let body = &prepared.body;
    let mmhg = stress_in_kpa("mmHg").unwrap_or(1.0);
    println!("{} nodes, {} cells", body.nodes, body.cell_count());
    let at_image = body.cavity_volumes(&vec![0.0; 3 * body.nodes]);
    for (cavity, volume) in body.cavities.iter().zip(at_image) {
        println!("volume of {} in the image: {} mL", cavity.name, digits(volume / 1e3, 4));
    }
    for (phase, values) in &prepared.phases {
        let said = values.iter().map(|(name, kpa)| {
            format!("{name} = {} kPa = {} mmHg", trimmed(*kpa, 4), trimmed(kpa / mmhg, 4))
        });
        println!("phase {phase}: {}", said.collect::<Vec<_>>().join(", "));
    }
    if let Some(segments) = &prepared.segments {
        println!("segments: {}", segments.names().join(", "));
    }
    for unknown in &prepared.problem.unknowns {
        let [low, high] = unknown.prior.range().map(|end| trimmed(unknown.shown(end), 4));
        println!("unknown: {} from {low} to {high}", unknown.head());
    }
}

/// Prints which parameters the data determine.
fn say_ahead(prepared: &Prepared, mode: &Mode, seen: &Identifiability) {
    println!("\nmost likely parameters:");
    for (unknown, theta) in prepared.problem.unknowns.iter().zip(&mode.theta) {
        let [low, high] = unknown.prior.range();
        let share = (theta / low).ln() / (high / low).ln();
        let end = match share {
            s if s < 0.02 => ", at the lower end of its range",
            s if s > 0.98 => ", at the upper end of its range",
            _ => "",
        };
        println!("  {} = {}{end}", unknown.head(), digits(unknown.shown(*theta), 3));
    }
    println!("data beside what the body does there:");
    for (datum, misfit) in prepared.problem.data.iter().zip(&mode.misfits) {
        let numbers = [datum.value, datum.error(), mode.observed.values[datum.observable]];
        let [value, error, model] = numbers.map(|number| digits(number / datum.size, 4));
        let (name, unit) = (&datum.name, &datum.unit);
        let mark = if misfit.abs() > DOUBTFUL { "  <- look at value, unit and phase" } else { "" };
        println!(
            "  {name}: measured {value} ± {error} {unit}, computed {model}, {misfit:+.1} sd{mark}"
        );
    }
    noise_in_words(&mode.misfits).iter().for_each(|doubt| println!("  warning: {doubt}"));
    println!("before anything is sampled:");
    seen.in_words().iter().for_each(|line| println!("  {line}"));
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
        let reason = "-o: this is the patient file itself; name another";
        refuse_if(same(&self.output, &self.patient), || reason)?;
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
