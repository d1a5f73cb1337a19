//! Shared parts of the study programs: reports with their provenance, kept results, test cases, trainings, exit, names of choices, random numbers.

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
use std::cmp::Ordering;
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

/// Smallest and largest value of the rows of a map.
pub(crate) fn range(rows: &[Vec<Option<f64>>]) -> [f64; 2] {
    let values = rows.iter().flatten().flatten().filter(|value| value.is_finite());
    let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(*value), high.max(*value)]
    });
    if ends[0] <= ends[1] { ends } else { [0.0, 1.0] }
}

/// Values up to which shares of all lie.
pub(crate) fn quantiles<T: Copy + PartialOrd, const N: usize>(
    mut values: Vec<T>,
    shares: [f64; N],
) -> [T; N] {
    values.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
    shares.map(|share| values[(share * (values.len() - 1) as f64) as usize])
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
