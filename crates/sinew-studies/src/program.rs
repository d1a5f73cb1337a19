//! Shared parts of the study programs: reports with their provenance, runs that begin or go on, kept results, test cases, trainings, exit,
//! names of choices, random numbers; CPU time and memory of this process.

use anyhow::{Context, Result, ensure};
use clap::ValueEnum;
use rand::Rng;
use serde::{Serialize, de::DeserializeOwned};
use sinew_emulate::{
    Body, Design, Simulations, Terminal, TestSet, TrainingOptions, simulate, split_seed, store,
};
use sinew_energy::{Parameter, Sampling};
use sinew_mesh::{FieldValues, read_npy};
use sinew_report::{Provenance, Report, Section};
use sinew_sample::standard_normals;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Says where the report is, or what went wrong.
pub fn end(report: Result<PathBuf>) -> ExitCode {
    match report {
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

/// Result of an earlier run in a file, where this one goes on; or a new one, written there.
pub(crate) fn kept<T: Serialize + DeserializeOwned>(
    file: &Path,
    resume: bool,
    make: impl FnOnce() -> Result<T>,
) -> Result<T> {
    // A file that is replaced may be of an earlier form.
    if resume && let Some(done) = store::read_json(file)? {
        return Ok(done);
    }
    let made = make()?;
    store::write_json(file, &made)?;
    Ok(made)
}

/// A report that is written anew after every section.
pub(crate) struct Growing {
    /// Sections present.
    pub report: Report,
    start: Instant,
    headline: fn(&Report) -> String,
}

impl Growing {
    /// Report of a study, by title and options; its sections say what it holds. A quick check means nothing.
    pub(crate) fn new(
        [title, about]: [&str; 2],
        (seed, quick): (u64, bool),
        options: &impl Serialize,
        headline: fn(&Report) -> String,
    ) -> Result<Self> {
        let about = match quick {
            true => {
                "A quick check of the code path on small meshes, with few cases and steps: its errors mean nothing."
            }
            false => about,
        };
        let report = Report::new(title, about, of_this_run(seed, options)?);
        Ok(Self { report, start: Instant::now(), headline })
    }

    /// Adds a section and writes all there is into a folder; the path of `report.html`.
    pub(crate) fn add(&mut self, section: Section, out: &Path) -> Result<PathBuf> {
        self.report.sections.push(section);
        self.report.headline = (self.headline)(&self.report);
        let so_far = std::mem::take(&mut self.report.provenance);
        self.report.provenance = so_far.finished(self.start.elapsed().as_secs_f64());
        Ok(self.report.write(out)?)
    }
}

/// Terms of a report that are not columns.
pub(crate) fn definitions<const N: usize>(terms: [(&str, &str); N]) -> Vec<(String, String)> {
    terms.map(|(term, text)| (term.to_string(), text.to_string())).to_vec()
}

/// Test cases uniform in the ranges, as the thesis has them whatever the parameters are trained at, solved or read from where an
/// interrupted run has left them; and the wall time of all solves \[s\].
pub(crate) fn test_set<'b>(
    body: &'b Body,
    cases: usize,
    seed: u64,
    folder: &Path,
) -> Result<(TestSet<'b>, f64)> {
    /// Seed stream of test cases.
    const TEST: u64 = 2;
    let linear = |p: &Parameter| Parameter { sampling: Sampling::Linear, ..p.clone() };
    let parameters: Vec<_> = body.parameters.iter().map(linear).collect();
    let thetas = Design::Uniform.sample(&parameters, cases, split_seed(seed, TEST))?;
    let (folder, stage) = (folder.join("test"), "solve test cases");
    let solved: Simulations =
        simulate(body, &thetas, stage, Some(&folder), &mut Terminal::default())?;
    ensure!(!solved.fields.is_empty(), "no test case has an equilibrium");
    let seconds = solved.seconds;
    Ok((TestSet::new(body, solved), seconds))
}

/// Training options of a recipe in a folder of a run; a quick check has few cases. Recipes beside each other share their
/// simulations; a run that is not resumed is replaced, as the rest of the study is.
pub(crate) fn training(quick: bool, seed: u64, folder: &Path, resume: bool) -> TrainingOptions {
    TrainingOptions {
        seed,
        held_out: if quick { 4 } else { 20 },
        evaluations: if quick { 2 } else { 20 },
        folder: Some(folder.to_path_buf()),
        shared: folder.parent().map(|run| run.join("simulations")),
        resume,
        restart: !resume,
        ..TrainingOptions::default()
    }
}

/// The upper median; none of nothing.
pub(crate) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Numbers of an npy file in `fixtures`, row by row.
pub(crate) fn fixture(file: &str) -> Result<Vec<f64>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(file);
    let array = read_npy(path).with_context(|| format!("fixture {file}"))?;
    Ok(match array.values {
        FieldValues::Float(values) => values,
        FieldValues::Integer(values) => values.iter().map(|&v| v as f64).collect(),
    })
}

/// A standard normal number.
pub(crate) fn standard_normal(random: &mut impl Rng) -> f64 {
    standard_normals(1, random)[0]
}

/// Name of a choice on the command line.
pub(crate) fn key(choice: impl ValueEnum) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().into())
}

/// Packages that numbers depend on.
const NUMERIC: &[&str] = &[
    "sinew-studies",
    "sinew-gp",
    "burn",
    "burn-flex",
    "chacha20",
    "faer",
    "kiddo",
    "linfa-clustering",
    "nalgebra",
    "rand_chacha",
];

/// Manifest of the running program, with the versions in the lock file it was built with.
pub fn of_this_run(seed: u64, config: &impl serde::Serialize) -> anyhow::Result<Provenance> {
    let mut provenance = Provenance::of_this_run("cargo xtask", env!("CARGO_MANIFEST_DIR"));
    let mut name = "";
    for line in include_str!("../../../Cargo.lock").lines() {
        let quoted = |key: &str| line.strip_prefix(key)?.strip_prefix(" = \"")?.strip_suffix('"');
        if let Some(found) = quoted("name") {
            name = found;
        } else if let Some(version) = quoted("version").filter(|_| NUMERIC.contains(&name)) {
            provenance.versions.insert(name.into(), version.into());
        }
    }
    Ok(Provenance {
        seed: Some(seed),
        threads: rayon::current_num_threads(),
        config: toml::to_string_pretty(config)?,
        ..provenance
    })
}

/// Requires the options that what is at a place was made with, but for the parts that were asked for.
pub(crate) fn same_options<T: Serialize>(stored: &T, options: &T, place: &Path) -> Result<()> {
    let table = |options: &T| -> Result<toml::Table> {
        let mut table = toml::Table::try_from(options)?;
        table.remove("only");
        Ok(table)
    };
    ensure!(
        table(stored)? == table(options)?,
        "{} was begun with other options ({}); repeat them, or start anew without --resume",
        place.display(),
        toml::to_string(stored)?.trim().replace('\n', ", ")
    );
    Ok(())
}

/// Begins a run in `out`, emptied of the `folders` of an earlier one, and keeps what it was begun with there; or returns what the run
/// that goes on was begun with.
pub(crate) fn begin_in<T: Serialize + DeserializeOwned>(
    out: &Path,
    folders: &[String],
    resume: bool,
    beginning: &T,
) -> Result<Option<T>> {
    let file = out.join("config.json");
    ensure!(
        !resume || file.exists(),
        "there is no run to resume in {}; start it without --resume",
        out.display()
    );
    let folders: Vec<_> = folders.iter().map(|name| out.join(name)).collect();
    begin(&file, &folders, resume, beginning)
}

/// Begins a run anew, in `folders` emptied of an earlier one, and keeps in `file` what it was begun with; or returns what the run
/// that goes on was begun with.
pub(crate) fn begin<T: Serialize + DeserializeOwned>(
    file: &Path,
    folders: &[PathBuf],
    resume: bool,
    beginning: &T,
) -> Result<Option<T>> {
    // What a run replaces may be of an earlier form.
    if resume && let Some(stored) = store::read_json(file)? {
        return Ok(Some(stored));
    }
    for old in folders.iter().map(PathBuf::as_path).filter(|old| old.exists()) {
        ensure!(
            file.exists(),
            "{} exists but is not of an earlier run; choose another --out",
            old.display()
        );
        std::fs::remove_dir_all(old)
            .with_context(|| format!("{} could not be emptied", old.display()))?;
    }
    store::write_json(file, beginning)?;
    Ok(None)
}

/// CPU time of this process on all its threads \[s\]; NaN where the system does not tell.
pub fn cpu_seconds() -> f64 {
    spent(OWN)
}

/// CPU time of the processes that this one started and that have ended \[s\]; NaN where the system does not tell.
pub(crate) fn cpu_seconds_of_children() -> f64 {
    spent(OWN + 2)
}

/// CPU time of one call \[s\], on all threads, over as many calls as take half a second, in a quick check a twentieth:
/// on a busy machine wall time is that of others, too.
pub(crate) fn cpu_seconds_of<T>(quick: bool, mut call: impl FnMut() -> Result<T>) -> Result<f64> {
    /// Long beside a tick of the clock \[s\].
    const ENOUGH: [f64; 2] = [0.5, 0.05];
    let (start, mut calls) = (cpu_seconds(), 0.0);
    loop {
        call()?;
        calls += 1.0;
        let spent = cpu_seconds() - start;
        if spent.is_nan() || spent >= ENOUGH[usize::from(quick)] {
            return Ok(spent / calls);
        }
    }
}

/// Place of user time among the fields of `/proc/self/stat` after the name, which may hold spaces; system time follows.
const OWN: usize = 11;

fn spent(first: usize) -> f64 {
    /// Clock ticks in a second, which Linux fixes for programs.
    const TICKS: f64 = 100.0;
    let status = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = status.rsplit(')').next().unwrap_or_default().split_whitespace();
    let ticks: Vec<f64> =
        fields.skip(first).take(2).filter_map(|field| field.parse().ok()).collect();
    if ticks.len() == 2 { (ticks[0] + ticks[1]) / TICKS } else { f64::NAN }
}

/// Largest resident memory of this process so far \[kB\], where the system tells it.
pub(crate) fn peak_kb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse().ok()
}
