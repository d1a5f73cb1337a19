//! Equilibria along a parameter, each from the one before.

use super::{ThetaArguments, Usage, single, warn, warn_of_locking};
use anyhow::{Result, anyhow};
use sinew::output::{Results, Row};
use sinew::{
    Body, Options, Parameter, Solution, admissible, outside, parse_way, range_in_words,
    theta_in_words,
};
use sinew_emulate::{Counter, Terminal};
use sinew_fem::{Solver, TraceEnd, locking};
use std::path::Path;

/// Path in θ and number of frames.
#[derive(Debug, clap::Args)]
pub(crate) struct Way {
    /// Solve along a path of one parameter: NAME=START..END, such as p=0..8mmHg. An end without unit has the parameter's, and is
    /// refused beside another one, but for 0. START is reached from rest by load increments; --theta gives the others
    #[arg(long, value_name = "NAME=START..END", conflicts_with_all = ["check_mesh", "load_steps", "pictures", "arrays"])]
    along: Option<String>,
    /// Steps of the path; there is one frame more than steps
    #[arg(long, value_name = "COUNT", default_value_t = 20, requires = "along", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: u32,
}

impl Way {
    /// The way, if there is one.
    pub(crate) fn given(&self) -> Option<&str> {
        self.along.as_deref()
    }

    /// Follows the way, and writes what is found.
    pub(crate) fn follow(
        &self,
        way: &str,
        body: &Body,
        theta: &ThetaArguments,
        stresses: bool,
        folder: &Path,
    ) -> Result<()> {
        let (index, ends) = parse_way(way, &body.parameters)?;
        let given = theta.read(body, Some(index))?.thetas();
        let theta = single("--along", &given)?;
        let at = |frame: u32| {
            let part = f64::from(frame) / f64::from(self.frames);
            let mut theta = theta.clone();
            // Without rounding at either end.
            theta[index] = (1.0 - part) * ends[0] + part * ends[1];
            theta
        };
        let thetas: Vec<Vec<f64>> = (0..=self.frames).map(at).collect();
        for end in [&thetas[0], &thetas[thetas.len() - 1]] {
            admissible(body, end).map_err(|why| Usage(format!("--along {way}: {why}")))?;
        }
        tell(&body.parameters[index], ends);
        let (frames, end) = traced(body, &thetas)?;
        let rows = frames.iter().map(|frame| Row {
            theta: frame.theta.clone(),
            fields: vec![&frame.displacement],
            pressure: &frame.pressure,
            ..Row::default()
        });
        let results = Results { body, names: vec!["solved"], rows: rows.collect(), stresses };
        let unit = &body.parameters[index].unit;
        let loads: Vec<f64> = thetas.iter().map(|theta| unit.shown(theta[index])).collect();
        results.write_along(folder, index, &loads)?;
        if let Some(Solution { theta, displacement, .. }) = frames.last() {
            warn_of_locking(locking(body, theta, displacement));
        }
        println!("written: {}", folder.display());
        match end {
            None => Ok(()),
            Some(end) => Err(ended(body, &end, frames.len(), thetas.len())),
        }
    }
}

/// Prints a path as it was read, and tells ends outside their range on standard error.
fn tell(parameter: &Parameter, ends: [f64; 2]) {
    println!("{}", range_in_words(&Parameter { range: ends, ..parameter.clone() }));
    let parameters = std::slice::from_ref(parameter);
    warn(ends.iter().flat_map(|&end| outside(parameters, &[end])));
}

/// Frames as far as the path goes.
fn traced(body: &Body, thetas: &[Vec<f64>]) -> Result<(Vec<Solution>, Option<TraceEnd>)> {
    let options = Options::default();
    let mut terminal = Terminal::default();
    let mut counter = Counter::new(&mut terminal, "follow", 0, thetas.len());
    let count = || {
        // The observer cannot break: an interruption ends the process.
        let _ = counter.step(1, "");
    };
    let trace = Solver::new(body)?.trace(thetas, &options, count)?;
    let frames = trace.solutions;
    counter.finish(&format!("{} frames", frames.len()));
    Ok((frames, trace.end))
}

/// Error that says where a path ended, and why.
fn ended(body: &Body, end: &TraceEnd, found: usize, asked: usize) -> anyhow::Error {
    let reached = theta_in_words(body, &end.reached);
    let beyond = theta_in_words(body, &end.beyond);
    let why = match &end.error {
        None => "the nearest equilibrium there is on another branch: a limit point or a bifurcation lies between them".into(),
        Some(error) => error.to_string(),
    };
    anyhow!(
        "{found} of {asked} frames were found and written; the path ends between {reached} and {beyond}: {why}"
    )
}
