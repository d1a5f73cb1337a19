//! Equilibria of a case, with a potential or without.

use super::{solved_by, tell_doubtful};
use anyhow::{Result, bail};
use sinew::{Options, Simulations};
use sinew_emulate::{Counter, Failure, Terminal};
use sinew_energy::Body;
use sinew_fem::sweep;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Equilibria, and fields of pressure beside them.
#[derive(Debug)]
pub(crate) struct Equilibria {
    /// Displacements, failures and times.
    pub simulations: Simulations,
    /// Pressures of mixed elements, equilibrium by equilibrium \[stress\]; empty without such a field.
    pub pressures: Vec<Vec<f64>>,
}

impl Equilibria {
    /// Field of pressure of an equilibrium, if the body has one.
    pub(crate) fn pressure(&self, place: usize) -> Option<&[f64]> {
        self.pressures.get(place).map(Vec::as_slice).filter(|field| !field.is_empty())
    }
}

/// Solves with a bar on the terminal.
pub(crate) fn equilibria(
    body: &Body,
    thetas: &[Vec<f64>],
    stage: &str,
    options: &Options,
) -> Result<Equilibria> {
    if body.has_potential() {
        let simulations = solved_by(body, thetas, stage, None, options)?;
        return Ok(Equilibria { simulations, pressures: Vec::new() });
    }
    balanced(body, thetas, stage, options)
}

/// Solves a body without a potential.
fn balanced(
    body: &Body,
    thetas: &[Vec<f64>],
    stage: &str,
    options: &Options,
) -> Result<Equilibria> {
    let (start, stop) = (Instant::now(), AtomicBool::new(false));
    let mut terminal = Terminal::default();
    let counter = Mutex::new(Counter::new(&mut terminal, stage, 0, thetas.len()));
    let swept = sweep(body, thetas, options, || {
        let mut counter = counter.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if counter.step(1, "").is_break() {
            stop.store(true, Ordering::Relaxed);
        }
    })?;
    if stop.into_inner() {
        bail!("{stage}: interrupted");
    }
    let mut found = Equilibria { simulations: Simulations::default(), pressures: Vec::new() };
    let simulations = &mut found.simulations;
    for (theta, result) in thetas.iter().zip(swept.results) {
        match result {
            Ok(solution) => {
                simulations.thetas.push(theta.clone());
                simulations.fields.push(solution.displacement);
                simulations.solve_seconds.push(solution.seconds);
                found.pressures.push(solution.pressure);
            }
            Err(error) => simulations
                .failures
                .push(Failure { theta: theta.clone(), reason: error.to_string() }),
        }
    }
    tell_doubtful(body, simulations.fields.iter().map(Vec::as_slice));
    simulations.seconds = start.elapsed().as_secs_f64();
    let counter = counter.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    let failed = match simulations.failures.len() {
        0 => String::new(),
        failed => format!(", {failed} failed"),
    };
    counter.finish(&format!("{} solves{failed}", simulations.fields.len()));
    Ok(found)
}
