//! The thesis' page, from the command line to the file.

use super::compare::Runs;
use super::filled::{PAGES, fill};
use super::page::{page, picture};
use super::printed::{Run, Table, thesis};
use super::stored::Stored;
use crate::program::cpu_seconds_of_children;
use anyhow::{Context, Result, ensure};
use clap::Parser;
use sinew_emulate::store;
use sinew_report::Report;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Compare every figure that the thesis prints with ours: run the studies that are missing, and write docs/thesis.md and the tables of other pages from their reports.
///
/// An interrupted run continues. Reports of finished runs are kept in docs/thesis, and these runs are not repeated.
#[derive(Parser, Clone, Debug)]
#[command(name = "cargo xtask thesis", version, max_term_width = 110)]
pub struct Options {
    /// Chapters (1, 2, 3, 4, A, B) or runs, separated by commas [default: all]
    #[arg(long, value_delimiter = ',', value_parser = keys())]
    pub only: Vec<String>,
    /// Small runs that check the code: no results, repeated each time; their page is written into the folder of the runs
    #[arg(long)]
    pub quick: bool,
    /// Run nothing: write the pages from the kept reports
    #[arg(long)]
    pub write: bool,
    /// Repeat finished runs, too
    #[arg(long, conflicts_with_all = ["write", "quick"])]
    pub again: bool,
    /// Folder for the runs
    #[arg(long, default_value = "out/thesis")]
    pub out: PathBuf,
}

fn keys() -> Vec<&'static str> {
    let chapters = thesis().table.iter().map(|table| &*table.chapter);
    let mut keys: Vec<_> = chapters.chain(thesis().run.iter().map(|run| &*run.name)).collect();
    keys.sort_unstable();
    keys.dedup();
    keys
}

/// Folder of the documents of this workspace.
fn documents() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new("")).join("docs")
}

/// Kept reports of all runs.
///
/// # Errors
/// A file that cannot be read.
pub fn kept() -> Result<Runs> {
    let folder = documents().join("thesis");
    let mut runs = Runs::new();
    for run in &thesis().run {
        runs.extend(Stored::read(&folder, &run.name)?.map(|stored| (run.name.clone(), stored)));
    }
    Ok(runs)
}

/// Runs what is missing and writes the page; its path.
///
/// # Errors
/// A run that fails; files that cannot be read or written. Runs that are done are kept.
pub fn reproduce(options: &Options) -> Result<PathBuf> {
    let (mut runs, page_file) = match options.quick {
        true => (Runs::new(), options.out.join("thesis.md")),
        false => (kept()?, documents().join("thesis.md")),
    };
    let missing: Vec<&Run> = thesis().run.iter().filter(|run| options.wants(run, &runs)).collect();
    let mut left: f64 = missing.iter().map(|run| run.minutes).sum();
    for (index, run) in missing.iter().enumerate() {
        let (number, of) = (index + 1, missing.len());
        let time = if options.quick {
            String::new()
        } else {
            format!(", about {:.0} of {left:.0} CPU minutes", run.minutes)
        };
        eprintln!("\n== run {number} of {of}, {}{time}: {}", run.name, run.command());
        let stored = options.run(run).with_context(|| format!("run {}", run.name))?;
        if !options.quick {
            stored.write(&documents().join("thesis"), &run.name)?;
        }
        runs.insert(run.name.clone(), stored);
        write(&page_file, &runs)?;
        left -= run.minutes;
    }
    write(&page_file, &runs)?;
    if !options.quick {
        fill_pages(&runs)?;
    }
    Ok(page_file)
}

/// Writes the page, and its picture beside it.
fn write(page_file: &Path, runs: &Runs) -> Result<()> {
    store::write_bytes(page_file, page(runs)?.as_bytes())?;
    Ok(store::write_bytes(&page_file.with_extension("svg"), picture(runs)?.as_bytes())?)
}

fn fill_pages(runs: &Runs) -> Result<()> {
    for name in PAGES {
        let file = documents().join(name);
        let text = std::fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        let filled = fill(&text, runs).with_context(|| format!("docs/{name}"))?;
        store::write_bytes(&file, filled.as_bytes())?;
    }
    Ok(())
}

impl Run {
    /// Command that repeats the run.
    pub fn command(&self) -> String {
        format!("cargo xtask {} {}", self.task, self.arguments)
    }
}

impl Options {
    fn wants(&self, run: &Run, kept: &Runs) -> bool {
        let named = |table: &Table| [&run.name, &run.repeats].contains(&&table.run);
        let of = |table: &Table| named(table) && self.only.contains(&table.chapter);
        let chosen =
            self.only.is_empty() || self.only.contains(&run.name) || thesis().table.iter().any(of);
        let done = kept.get(&run.name).is_some_and(|stored| stored.command == run.command());
        chosen && !self.write && (self.again || !done)
    }

    /// Runs a study in its folder, going on where it was interrupted.
    fn run(&self, run: &Run) -> Result<Stored> {
        let out = self.out.join(&run.name);
        // A check is repeated; so is a run that was finished.
        let (report, cost) = (out.join("report.json"), out.join("cpu.json"));
        let earlier: Option<f64> = store::read_json(&cost)?.filter(|_| !self.quick);
        let mut arguments: Vec<&str> = run.arguments.split(' ').collect();
        if self.quick {
            if let Some(at) = arguments.iter().position(|argument| *argument == "--budget") {
                arguments.drain(at..at + 2);
            }
            arguments.push("--quick");
        } else if earlier.is_some() {
            arguments.push("--resume");
        } else {
            store::write_json(&cost, &0.0)?;
        }
        let program = std::env::current_exe()?;
        let before = cpu_seconds_of_children();
        let status =
            Command::new(&program).arg(&run.task).args(arguments).arg("--out").arg(&out).status();
        let status = status.with_context(|| program.display().to_string())?;
        let spent = cpu_seconds_of_children() - before + earlier.unwrap_or(0.0);
        store::write_json(&cost, &spent)?;
        ensure!(status.success(), "{} ended with {status}", run.command());
        let mut report = Report::read(&report)?;
        // A kept report names no folder of this machine.
        let (folder, named) = (out.display().to_string(), format!("out/thesis/{}", run.name));
        for text in [&mut report.provenance.command, &mut report.provenance.config] {
            *text = text.replace(&folder, &named);
        }
        let stored = Stored::new(run.command(), Some(spent), report);
        std::fs::remove_file(&cost)?;
        Ok(stored)
    }
}
