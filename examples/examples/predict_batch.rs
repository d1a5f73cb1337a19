//! Predicts many parameter sets at once with an emulator that `train_emulator` wrote, and says how long it
//! took and how far from the solver it is.
//!
//! ```sh
//! cargo run -p sinew-examples --example predict_batch -- 200
//! ```

use anyhow::{Context, Result};
use sinew_emulate::{Design, Emulator, Terminal, TestSet, simulate};
use std::path::Path;

fn main() -> Result<()> {
    let count = std::env::args().nth(1).unwrap_or_else(|| "200".into());
    let count: usize = count.parse().with_context(|| format!("{count:?} is no count"))?;
    let body = sinew_examples::bar()?;
    let emulator = Emulator::load(Path::new("out/bar/emulator"), &body)
        .context("run train_emulator in this folder first")?;
    let thetas = Design::Sobol.sample(&body.parameters, count, 7)?;
    let solved = simulate(&body, &thetas, "solve", None, &mut Terminal::default())?;
    let solver_ms = 1e3 * solved.seconds / thetas.len() as f64;
    let evaluation = emulator.evaluate(&TestSet::new(&body, solved), 1)?;
    println!("{count} parameter sets, {} nodes", body.nodes);
    let (raw, corrected) = (&evaluation.raw.err_u, &evaluation.corrected[0].errors.err_u);
    println!(
        "emulator  {:.3} ms per set, median error {:.2e} mm, largest {:.2e} mm",
        1e3 * evaluation.times.predict_batch_per_theta_s,
        raw.q50,
        raw.max
    );
    println!(
        "corrected {:.3} ms more,    median error {:.2e} mm, largest {:.2e} mm",
        1e3 * evaluation.times.correction_s,
        corrected.q50,
        corrected.max
    );
    println!("solver    {solver_ms:.3} ms per set, the reference of these errors");
    Ok(())
}
