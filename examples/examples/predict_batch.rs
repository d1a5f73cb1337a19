//! Predicts many parameter sets at once with an emulator that `train_emulator` wrote, and says how long it
//! took and how far from the solver it is.
//!
//! ```sh
//! cargo run -p sinew-examples --example predict_batch -- examples/cases/hanging_bar.toml 200
//! ```

use anyhow::{Context, Result, bail};
use sinew_energy::metrics::displacement_error;
use sinew_examples::Case;
use sinew_fem::{Options, Solver, sweep};
use sinew_gnn::{Backend, Surrogate};
use std::path::Path;
use std::time::Instant;

const HELP: &str = "usage: predict_batch [CASE.toml [COUNT]]

Run train_emulator with the same case first. Without arguments: the case that comes with the examples
and 200 parameter sets.";

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (case, count) = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--help" | "-h"] => {
            println!("{HELP}");
            return Ok(());
        }
        [] => (Case::bundled()?, 200),
        [path] => (Case::read(Path::new(path))?, 200),
        [path, count] => {
            let count = count.parse().with_context(|| format!("COUNT is {count:?}\n\n{HELP}"))?;
            (Case::read(Path::new(path))?, count)
        }
        _ => bail!("too many arguments\n\n{HELP}"),
    };
    predict(&case, count)
}

fn predict(case: &Case, count: usize) -> Result<()> {
    let body = case.prepare()?;
    let surrogate = Surrogate::load(&case.output.join("emulator"), &Backend::Flex.device()?)
        .context("run train_emulator with the same case first")?;
    // Parameter sets beyond those trained on.
    let thetas = case.thetas(case.training.samples..case.training.samples + count.max(1));

    // Message passing once, then only the decoder. The first batch warms caches and threads.
    let fixed = surrogate.fixed_geometry(&body.geometry)?;
    fixed.predict(&thetas)?;
    let start = Instant::now();
    let prediction = fixed.predict(&thetas)?;
    let emulated_ms = 1e3 * start.elapsed().as_secs_f64() / thetas.len() as f64;

    let start = Instant::now();
    let swept = sweep(&body.potential, &thetas, &Options::default(), || ())?;
    let solved_ms = 1e3 * start.elapsed().as_secs_f64() / thetas.len() as f64;
    let solutions = swept.solutions()?;
    let mut errors = Vec::new();
    for (index, solution) in solutions.iter().enumerate() {
        errors.extend(displacement_error(&solution.displacement, prediction.field(index)));
    }
    errors.sort_by(f64::total_cmp);
    println!("{} parameter sets, {} nodes", thetas.len(), body.potential.nodes);
    println!(
        "emulator  {emulated_ms:.3} ms per set, median error {:.2e} mm, largest {:.2e} mm",
        errors[errors.len() / 2],
        errors[errors.len() - 1]
    );
    println!("solver    {solved_ms:.3} ms per set, the reference of these errors");

    // One row per parameter, as the displacements.
    let emulated = fixed.sensitivity(&thetas[..1])?.derivative;
    let solved = Solver::new(&body.potential)?.sensitivity(solutions[0])?;
    let largest = |row: &[f64]| row.iter().fold(0.0f64, |most, d| most.max(d.abs()));
    println!("largest derivatives at mu, lambda = {:.1?} kPa [mm/kPa]", thetas[0]);
    let rows = emulated.chunks_exact(prediction.field(0).len()).zip(&solved);
    for (name, (emulated, solved)) in ["mu", "lambda"].iter().zip(rows) {
        println!(
            "  |du/d{name}|: emulator {:.3}, solver {:.3}",
            largest(emulated),
            largest(solved)
        );
    }
    Ok(())
}
