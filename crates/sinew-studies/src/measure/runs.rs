//! Emulators of stored runs against runs that are held back: R², error beside the one stated, coverage of intervals.

use anyhow::Result;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use sinew::Design;
use sinew::runs::Runs;
use sinew_emulate::{Output, RunsEmulator};
use sinew_energy::Parameter;
use std::path::PathBuf;
use std::time::Instant;

/// A table of runs; smooth functions of four parameters without it.
#[derive(clap::Args)]
pub struct Arguments {
    /// CSV table of runs, as of `sinew train --from-table`
    #[arg(requires = "parameters")]
    table: Option<PathBuf>,
    /// Columns that are parameters
    #[arg(long, value_name = "NAMES")]
    parameters: Option<String>,
}

/// Parts of a table that are held back in turn.
const FOLDS: usize = 5;

/// Runs of the functions, and runs among them that are learned from.
const FUNCTIONS: usize = 5400;
const LEARNED: usize = 400;

/// Prints a line for each output.
pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let runs = match &arguments.table {
        Some(table) => {
            let parameters = arguments.parameters.as_deref().unwrap_or_default();
            Runs::read_table(table, parameters, None)?
        }
        None => functions()?,
    };
    let count = runs.thetas.len();
    let mut order: Vec<usize> = (0..count).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(0));
    let folds: Vec<(Vec<usize>, Vec<usize>)> = match arguments.table {
        Some(_) => {
            (0..FOLDS).map(|fold| order.iter().partition(|&&run| run % FOLDS != fold)).collect()
        }
        None => vec![(order.drain(..LEARNED).collect(), order)],
    };
    let mut tested: Vec<Vec<Tested>> = runs.outputs.iter().map(|_| Vec::new()).collect();
    let start = Instant::now();
    for (learned, held_back) in &folds {
        let rows = |all: &[Vec<f64>]| learned.iter().map(|&run| all[run].clone()).collect();
        let part = |output: &Output| Output { values: rows(&output.values), ..output.clone() };
        let outputs: Vec<Output> = runs.outputs.iter().map(part).collect();
        let thetas: Vec<Vec<f64>> = rows(&runs.thetas);
        let emulator =
            RunsEmulator::fit(runs.parameters.clone(), &thetas, &outputs, None, &mut ())?;
        for &run in held_back {
            let found = emulator.predict(&runs.thetas[run])?;
            for (place, found) in found.iter().enumerate() {
                tested[place].push(Tested {
                    truth: runs.outputs[place].values[run][0],
                    found: found.values[0],
                    half_width: found.half_width,
                    stated: emulator.left_out()[place].error,
                });
            }
        }
    }
    let seconds = start.elapsed().as_secs_f64() / folds.len() as f64;
    println!(
        "{count} runs, {} times {} of them learned, {seconds:.1} s each",
        folds.len(),
        folds[0].0.len()
    );
    for (output, tested) in runs.outputs.iter().zip(&tested) {
        println!("{}: {}", output.name, in_words(tested));
    }
    Ok(())
}

/// A run that was held back.
struct Tested {
    truth: f64,
    found: f64,
    half_width: f64,
    stated: f64,
}

fn in_words(tested: &[Tested]) -> String {
    let mean =
        |of: &dyn Fn(&Tested) -> f64| tested.iter().map(of).sum::<f64>() / tested.len() as f64;
    let centre = mean(&|of| of.truth);
    let [square, variance, stated] = [
        mean(&|of| (of.found - of.truth).powi(2)),
        mean(&|of| (of.truth - centre).powi(2)),
        mean(&|of| of.stated.powi(2)),
    ];
    let held = mean(&|of| f64::from((of.found - of.truth).abs() <= of.half_width));
    format!(
        "share of the variance unexplained {:.2e} (R² {:.5}), error {:.2} of the one stated, intervals hold {held:.3}",
        square / variance,
        1.0 - square / variance,
        (square / stated).sqrt()
    )
}

fn functions() -> Result<Runs> {
    let names = ["a", "b", "c", "d"];
    let parameters = names.map(|name| Parameter::linear(name, "1", 0.5..=2.0));
    let thetas = Design::Uniform.sample(&parameters, FUNCTIONS, 1)?;
    type Function = fn(&[f64]) -> f64;
    let functions: [(&str, Function); 6] = [
        ("ratio", |t| t[0] / (t[1] + 0.3 * t[2])),
        ("exponential", |t| (0.8 * t[0] * t[1]).exp() - t[3]),
        ("root", |t| (t[0] * t[0] + t[2] * t[3]).sqrt()),
        ("wave", |t| (1.5 * t[0]).sin() * (1.2 * t[1]).cos() + 0.2 * t[2]),
        ("logarithm", |t| (t[0] + t[1] * t[2] * t[3]).ln()),
        ("saturation", |t| (t[3] * (t[0] - t[1])).tanh() + t[2]),
    ];
    let output = |(name, of): (&str, Function)| Output {
        name: name.into(),
        unit: "1".into(),
        values: thetas.iter().map(|theta| vec![of(theta)]).collect(),
    };
    let outputs = functions.into_iter().map(output).collect();
    let (parameters, warnings) = (parameters.to_vec(), Vec::new());
    Ok(Runs { parameters, thetas, outputs, mesh: None, warnings })
}
