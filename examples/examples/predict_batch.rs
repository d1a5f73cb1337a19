//! Predicts many parameter sets at once with an emulator that `train_emulator` wrote, and says how long it
//! took and how far from the solver it is.
//!
//! ```sh
//! cargo run -p sinew-examples --example predict_batch -- examples/cases/hanging_bar.toml 200
//! ```

use anyhow::{Context, Result};
use sinew_energy::metrics::displacement_error;
use sinew_examples::Case;
use sinew_fem::{Options, sweep};
use sinew_gnn::{Backend, Surrogate};
use std::path::Path;
use std::time::Instant;

fn main() -> Result<()> {
    let usage = "usage: predict_batch CASE.toml [COUNT], after train_emulator CASE.toml";
    let path = std::env::args().nth(1).context(usage)?;
    if path == "--help" || path == "-h" {
        println!("{usage}");
        return Ok(());
    }
    let count: usize =
        std::env::args().nth(2).map_or(Ok(200), |text| text.parse()).context(usage)?;
    let case = Case::read(Path::new(&path))?;
    let body = case.prepare()?;
    let surrogate = Surrogate::load(&case.output.join("emulator"), &Backend::Flex.device()?)
        .context("run train_emulator with the same case first")?;

    // Message passing once, then only the decoder.
    let fixed = surrogate.fixed_geometry(&body.geometry)?;
    let thetas = case.thetas(count.max(1));
    fixed.predict(&thetas)?;
    let start = Instant::now();
    let prediction = fixed.predict(&thetas)?;
    let emulated_ms = 1e3 * start.elapsed().as_secs_f64() / thetas.len() as f64;

    let start = Instant::now();
    let swept = sweep(&body.potential, &thetas, &Options::default(), || ())?;
    let solved_ms = 1e3 * start.elapsed().as_secs_f64() / thetas.len() as f64;
    let mut errors = Vec::new();
    for (case, solution) in swept.solutions()?.into_iter().enumerate() {
        errors.extend(displacement_error(&solution.displacement, prediction.field(case)));
    }
    errors.sort_by(f64::total_cmp);
    println!("{} parameter sets, {} nodes", thetas.len(), body.potential.nodes);
    println!(
        "emulator  {emulated_ms:.3} ms per set, median error {:.2e} mm, largest {:.2e} mm",
        errors[errors.len() / 2],
        errors[errors.len() - 1]
    );
    println!("solver    {solved_ms:.3} ms per set, the reference of these errors");

    let sensitivity = fixed.sensitivity(&thetas[..1])?;
    let size = prediction.field(0).len();
    for (name, derivative) in ["mu", "lambda"].iter().zip(sensitivity.derivative.chunks_exact(size))
    {
        let largest = derivative.iter().fold(0.0f64, |most, d| most.max(d.abs()));
        println!("largest |du/d{name}| at {:.1?}: {largest:.3} mm/kPa", thetas[0]);
    }
    Ok(())
}
