//! The program: which cases, with progress, to which files.

use crate::verify::case::{Case, Effort};
use crate::verify::{report, run};
use anyhow::{Result, bail};
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::time::Duration;

/// Compare the solver with references that share no code with it: a table, `report.json` and `report.html`.
/// Ends with an error when a value falls outside its stated band.
#[derive(Clone, Debug, Parser)]
#[command(name = "cargo xtask verify", version)]
pub struct Options {
    /// Only the cases whose names contain this text; may be given several times
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// List the cases and end
    #[arg(long)]
    pub list: bool,
    /// Coarse meshes only
    #[arg(long)]
    pub quick: bool,
    /// Folder of report.json and report.html
    #[arg(long, value_name = "DIR", default_value = "out/verify")]
    pub out: PathBuf,
}

/// Runs the chosen cases, prints the table and writes the files; `true` when every case passes.
///
/// # Errors
/// When no case has one of the names asked for, or a file cannot be written.
pub fn verify(cases: &[Case], options: &Options) -> Result<bool> {
    let chosen = chosen(cases, &options.only)?;
    if options.list {
        let widest = chosen.iter().map(|case| case.name.len()).max().unwrap_or(0);
        chosen.iter().for_each(|case| println!("{:<widest$}  {}", case.name, case.title));
        return Ok(true);
    }
    let effort = if options.quick { Effort::Quick } else { Effort::Full };
    let bar = progress(chosen.len() as u64);
    let mut outcomes = Vec::with_capacity(chosen.len());
    for case in chosen {
        bar.set_message(case.name);
        let outcome = run::run(case, effort);
        bar.suspend(|| print!("{}", report::table(&outcome)));
        bar.inc(1);
        outcomes.push(outcome);
    }
    bar.finish_and_clear();
    println!("\n{}", report::summary(&outcomes));
    let report = report::report(effort, &outcomes)?;
    println!("report: {}", report.write(&options.out)?.display());
    Ok(outcomes.iter().all(run::Outcome::passes))
}

fn chosen<'a>(cases: &'a [Case], only: &[String]) -> Result<Vec<&'a Case>> {
    for wanted in only {
        if !cases.iter().any(|case| case.name.contains(wanted.as_str())) {
            let names: Vec<_> = cases.iter().map(|case| case.name).collect();
            bail!("no case is named `{wanted}`; there are {}", names.join(", "));
        }
    }
    let is_wanted = |case: &&Case| {
        only.is_empty() || only.iter().any(|wanted| case.name.contains(wanted.as_str()))
    };
    Ok(cases.iter().filter(is_wanted).collect())
}

/// A bar over the cases on standard error; nothing when that is not a terminal.
fn progress(cases: u64) -> ProgressBar {
    let bar = ProgressBar::new(cases);
    let style = ProgressStyle::with_template("{spinner} {pos}/{len} {msg}  {elapsed}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
