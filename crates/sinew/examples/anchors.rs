//! Errors of Taylor expansions about several solved states, beside regression on as many solves, over uniform parameter sets.
//!
//! ```sh
//! cargo run --release -p sinew --example anchors -- LeftVentricle left_ventricle.vtk 12 1000
//! ```
//!
//! The mesh of a scene that has its own is `-`.

use sinew::{Case, Design, Emulator};
use sinew_emulate::PodRegression;
use sinew_energy::metrics::displacement_error;
use sinew_fem::{Options, sweep};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [case, mesh, anchors, sets] = &arguments[..] else {
        return Err("usage: anchors CASE MESH ANCHORS SETS, such as IdealVentricle - 12 100".into());
    };
    let (anchors, sets): (usize, usize) = (anchors.parse()?, sets.parse()?);
    let case = Case::read(Path::new(case))?;
    let case = if mesh == "-" { case } else { case.with_mesh(mesh.into()) };
    let body = case.body()?;
    let solved = |design: Design, count: usize| -> Result<_, Box<dyn Error>> {
        let thetas = design.sample(&body.parameters, count, 77)?;
        let solved = sweep(&body, &thetas, &Options::default(), || ())?;
        let fields: Vec<_> = solved.solutions()?.iter().map(|s| s.displacement.clone()).collect();
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
    let mut errors: Vec<f64> = pairs.flat_map(|(u, v)| displacement_error(u.as_ref(), v)).collect();
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[(share * (errors.len() - 1) as f64) as usize];
    println!("{method}: median {:.2e}, 99 % {:.2e}, largest {:.2e}", at(0.5), at(0.99), at(1.0));
}
