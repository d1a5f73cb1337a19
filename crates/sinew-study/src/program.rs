//! What the programs of all studies share: their end, their test cases, how they train.

use anyhow::{Result, ensure};
use sinew_emulate::{
    Body, Design, Simulations, Terminal, TestSet, TrainingOptions, simulate, split_seed,
};
use sinew_energy::{Parameter, Sampling};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Says where the report is, or the folder of what was only simulated, or what went wrong.
pub fn end(report: Result<PathBuf>) -> ExitCode {
    match report {
        Ok(report) => {
            let what = if report.is_dir() { "simulations" } else { "report" };
            eprintln!("\n{what}: {}", report.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("\nerror: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Test cases uniform in the ranges, as the thesis has them whatever the parameters are trained at, solved or read from where an
/// interrupted run has left them; and the wall time of all solves \[s\].
///
/// # Errors
/// A body of which no case has an equilibrium; files that cannot be written or read.
pub fn test_set<'b>(
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

/// How a recipe is trained in a folder of a run, which a quick check does with few cases.
pub fn training(quick: bool, seed: u64, folder: &Path, resume: bool) -> TrainingOptions {
    TrainingOptions {
        seed,
        held_out: if quick { 4 } else { 20 },
        evaluations: if quick { 2 } else { 20 },
        folder: Some(folder.to_path_buf()),
        resume,
        ..TrainingOptions::default()
    }
}
