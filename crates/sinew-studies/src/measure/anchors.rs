//! Errors of Taylor expansions about several solved states, beside regression on as many solves, over uniform parameter sets.

use crate::program::quantiles;
use anyhow::Result;
use sinew::{Case, Design, Emulator};
use sinew_emulate::PodRegression;
use sinew_energy::metrics::displacement_error;
use sinew_fem::{Options, sweep};
use std::path::PathBuf;
use std::time::Instant;

/// A case and its mesh, and how many states are solved.
#[derive(clap::Args)]
pub struct Arguments {
    /// Scene or case file
    case: PathBuf,
    /// Mesh; `-` for that of the case
    mesh: PathBuf,
    anchors: usize,
    /// Test cases
    sets: usize,
}

/// Prints a line for each method.
pub(super) fn run(arguments: Arguments) -> Result<()> {
    let Arguments { case, mesh, anchors, sets } = arguments;
    let case = Case::read(&case)?;
    let case = if mesh.as_os_str() == "-" { case } else { case.with_mesh(mesh) };
    let body = case.body()?;
    let solved = |design: Design, count: usize| -> Result<_> {
        let thetas = design.sample(&body.parameters, count, 77)?;
        let solved = sweep(&body, &thetas, &Options::default(), || ())?;
        let fields = solved.into_iter().map(|s| Ok(s?.displacement)).collect::<Result<Vec<_>>>()?;
        Ok((thetas, fields))
    };
    let (tested, truths) = solved(Design::Uniform, sets)?;
    let start = Instant::now();
    let expansion = Emulator::taylor_with_anchors(&body, anchors, 1)?;
    let prepared = start.elapsed().as_secs_f64();
    let found = expansion.predict(&tested)?.fields();
    tell(&format!("taylor, {anchors} anchors, {prepared:.1} s"), &found, &truths);
    let (learned, fields) = solved(Design::LatinHypercube, anchors)?;
    let regression = PodRegression::fit(&body.parameters, &learned, &fields)?;
    let found = tested.iter().map(|theta| regression.predict(theta));
    let found: Vec<_> = found.collect::<Result<_, _>>()?;
    tell(&format!("regression, {anchors} solves"), &found, &truths);
    Ok(())
}

/// Prints median, 99 % quantile and largest of all nodal errors.
fn tell<F: AsRef<[f64]>>(method: &str, found: &[F], truths: &[Vec<f64>]) {
    let pairs = found.iter().zip(truths);
    let errors: Vec<f64> = pairs.flat_map(|(u, v)| displacement_error(u.as_ref(), v)).collect();
    let [median, most, all] = quantiles(errors, [0.5, 0.99, 1.0]);
    println!("{method}: median {median:.2e}, 99 % {most:.2e}, largest {all:.2e}");
}
