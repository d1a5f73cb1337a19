//! An emulator of stored runs as a page.

use super::compact::{Compact, PREDICTIONS};
use super::fields::{ERROR_DEGREE, FACTOR, LEVEL};
use super::{CHECKED, NO_SURFACE, ROUNDING, Surface, corners, displacement, sliders};
use sinew_emulate::{Design, Error, PodRegression, Predicted, Result, RunsEmulator, split_seed};
use sinew_report::format::digits;
use sinew_report::{Viewer, ViewerEmulator};

const NUMBERS: &str = "a page shows displacements on a mesh, and this emulator has numbers alone; train it with --from-fields and --mesh, or with --files";

/// The page of an emulator of stored displacements: these at the surface, and the half-width of their 95 % interval over θ as a
/// regression. Same seed, same page.
///
/// # Errors
/// An emulator of numbers, a mesh that has no surface.
pub fn viewer_of_runs(emulator: &RunsEmulator, title: &str, seed: u64) -> Result<Viewer> {
    let (Some(mesh), Some(regression), [left]) =
        (&emulator.mesh, emulator.regression(), emulator.left_out())
    else {
        return Err(Error::Request(NUMBERS.into()));
    };
    let surface = Surface::of(mesh).ok_or_else(|| Error::Refused(NO_SURFACE.into()))?;
    let (parameters, unit) = (&emulator.parameters, left.unit.as_str());
    let thetas = Design::Sobol.sample(parameters, PREDICTIONS, split_seed(seed, 0))?;
    let others = Design::Uniform.sample(parameters, CHECKED, split_seed(seed, 1))?;
    let at = |theta: &Vec<f64>| Ok(emulator.predict(theta)?.remove(0));
    let width = |of: &Predicted| of.half_width.max(f64::MIN_POSITIVE).ln();
    let widths: Vec<_> =
        thetas.iter().map(|theta| Ok(vec![width(&at(theta)?)])).collect::<Result<_>>()?;
    let level = PodRegression::fit_polynomial(parameters, &thetas, &widths, ERROR_DEGREE)?;
    let checked: Vec<_> = others.iter().map(at).collect::<Result<_>>()?;
    let mut right = 0;
    for (theta, of) in others.iter().zip(&checked) {
        right += usize::from((level.predict(theta)?[0] - width(of)).abs() <= FACTOR.ln());
    }
    let level = Compact::of(level, None, &thetas, LEVEL)?;
    let thetas = [thetas, corners(parameters)].concat();
    let shown = Compact::of(regression.clone(), Some(&surface.rows()), &thetas, ROUNDING)?;
    let error = format!("{}, root mean square over the nodes", digits(left.error, 3));
    let told =
        format!("within a factor of {FACTOR} of the emulator's in {right} of {CHECKED} cases");
    let facts = [("error of runs left out", error), ("shown error", told)];
    Ok(Viewer {
        title: title.into(),
        about: format!("Gaussian process of {} stored runs", left.runs),
        length: unit.into(),
        points: surface.positions(mesh.points()),
        triangles: surface.packed(),
        quantities: vec![displacement(unit, &surface, checked.iter().map(|of| &of.values))],
        facts: facts.map(|(name, told)| (name.into(), told)).into(),
        notes: emulator.warnings.clone(),
        emulator: Some(ViewerEmulator {
            parameters: sliders(parameters, &[]),
            displacement: shown.packed(),
            error: Some(level.packed()),
            mesh: "from runs left out; no solver has confirmed it".into(),
            ..ViewerEmulator::default()
        }),
        ..Viewer::default()
    })
}
