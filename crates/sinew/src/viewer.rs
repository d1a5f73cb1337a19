//! An emulator as one page for a browser: a body that moves with sliders for its parameters, with its error shown.

mod compact;
mod fields;
mod runs;
mod surface;

use crate::{Emulator, locking_in_words};
use compact::{Compact, PREDICTIONS, Sampled, predicted, relative};
use fields::ErrorModel;
pub use runs::viewer_of_runs;
use serde_json::{Value, json};
use sinew_emulate::{Design, Error, Observer, PodRegression, Result, split_seed};
use sinew_energy::{Body, CavityPart, Lid, Magnitude, Parameter, PressureSurface, SymmetryPlane};
use sinew_fem::LockingWarning;
use sinew_report::format::digits;
use sinew_report::{Packed, Quantity, Slider, Source, Viewer, ViewerCavity, ViewerEmulator};
pub(crate) use surface::Surface;

/// Seed of the predictions that the program makes a page from.
pub const PAGE_SEED: u64 = 0x9a6e;
/// Predictions that they are measured on.
const CHECKED: usize = 100;
/// Highest total degree of polynomials.
const DEGREE: usize = 8;
/// Largest error that a page may add, relative to the emulator's own.
const MOST_ADDED: f64 = 1.0 / 3.0;
/// Error that a page may always add, relative to the displacement: it cannot be seen.
const INVISIBLE: f64 = 1e-6;
/// Largest error of a colour \[relative to the root mean square of its values\].
const MOST_OFF: f64 = 0.1;

const NO_SURFACE: &str =
    "the body has no surface to be shown; a page needs a mesh of tetrahedra or hexahedra";
const NOT_MEASURED: &str = "the emulator was not measured on held-out cases, so the error that a page adds cannot be judged; train it by a recipe";

/// Rounding error of the page's displacements \[relative to their norm\], below [`INVISIBLE`].
const ROUNDING: f64 = 8e-7;

/// An emulator as a page: its displacements at the surface, stress or fibres, cavities, and its error over θ.
///
/// The page evaluates a regression to within 1e-6. Any other emulator is replaced by a regression of 500 of its predictions,
/// and the page states its distance from 100 others. The error is a regression of checked error estimates
/// ([`sinew_fem::Solver::error_estimate`]) of the displayed displacements. The page states how often it is within a factor
/// of three.
/// Same seed, same page.
///
/// # Errors
/// An emulator that adds more than a third of its own error, and than 1e-6, when it is regressed, a body that has no surface, predictions of which
/// most invert cells.
pub fn viewer(emulator: &Emulator<'_>, seed: u64, observer: &mut dyn Observer) -> Result<Viewer> {
    let body = emulator.body();
    let surface = Surface::of(&body.mesh).ok_or_else(|| Error::Refused(NO_SURFACE.into()))?;
    let mut sample = |design: Design, count, stream| -> Result<Sampled> {
        let thetas = design.sample(&body.parameters, count, split_seed(seed, stream))?;
        let fields = predicted(emulator, &thetas, observer)?;
        Ok(Sampled { thetas, fields })
    };
    let fitted = sample(Design::Sobol, PREDICTIONS, 0)?;
    let checked = sample(Design::Uniform, CHECKED, 1)?;
    let motion = Motion::of(emulator, &surface, &fitted, &checked)?;
    let mut viewer = Viewer {
        title: body.name.clone(),
        about: emulator.record.about.split(',').next().unwrap_or_default().into(),
        length: body.units.length.clone(),
        points: surface.positions(&body.positions),
        triangles: surface.packed(),
        strokes: surface.strokes(body),
        facts: facts(emulator, &motion),
        notes: emulator.record.warnings.iter().map(ToString::to_string).collect(),
        ..Viewer::default()
    };
    viewer.quantities.push(displacement(&body.units.length, &surface, checked.fields.iter()));
    for (quantity, error) in fields::colours(body, &surface, &fitted, &checked)? {
        let mut told =
            format!("{} % off that of the emulator's predictions", digits(100.0 * error, 2));
        if error > MOST_OFF {
            told += ", so that it is left out";
        }
        viewer.facts.push((quantity.name.clone(), told));
        viewer.quantities.extend((error <= MOST_OFF).then_some(quantity));
    }
    let locking = sinew_fem::locking_at_centre(body);
    let mesh = discretisation(body, locking.as_ref().ok().map(Option::as_ref));
    viewer.notes.extend(locking.ok().flatten().iter().map(locking_in_words));
    let found = ErrorModel::of(emulator, &motion.shown, &surface, &fitted, &checked, observer)?;
    viewer.facts.push(("shown error".into(), found.told.clone()));
    viewer.quantities.extend(found.quantity);
    viewer.emulator = Some(ViewerEmulator {
        parameters: sliders(&body.parameters, &body.pressures),
        displacement: motion.shown.packed(),
        error: found.level,
        mesh,
        ..cavities(body, &surface, &fitted)
    });
    Ok(viewer)
}

/// Displacements as the page computes them.
struct Motion {
    shown: Compact,
    /// Mean relative distance from the emulator's predictions; `None` where the page evaluates the emulator itself.
    added: Option<f64>,
}

impl Motion {
    fn of(
        emulator: &Emulator<'_>,
        surface: &Surface,
        fitted: &Sampled,
        checked: &Sampled,
    ) -> Result<Self> {
        let parameters = &emulator.body().parameters;
        // Displacements are smallest at a corner of the ranges mostly.
        let thetas = [fitted.thetas.as_slice(), &corners(parameters)].concat();
        if let Some(regression) = emulator.predictor.regression() {
            let rows = surface.rows();
            let shown = Compact::of(regression.clone(), Some(&rows), &thetas, ROUNDING)?;
            return Ok(Self { shown, added: None });
        }
        let own = emulator.record.held_out.as_ref();
        let own = own.ok_or_else(|| Error::Refused(NOT_MEASURED.into()))?.relative.mean;
        let at = |field: &Vec<f64>| surface.of_field(field);
        let fields: Vec<_> = fitted.fields.iter().map(at).collect();
        let regression =
            PodRegression::fit_polynomial(parameters, &fitted.thetas, &fields, DEGREE)?;
        let shown = Compact::of(regression, None, &thetas, ROUNDING)?;
        let [added, _] = relative(&shown, checked, at)?;
        // Written so that a NaN is refused as well.
        let bearable = added <= INVISIBLE.max(MOST_ADDED * own);
        if !bearable {
            return Err(Error::Refused(format!(
                "a page cannot hold this emulator: a regression of {PREDICTIONS} of its predictions is {added:.1e} of the displacement off \
                 them, more than a third of the emulator's own error of {own:.1e}; export one of the recipe regression, or train over \
                 smaller ranges"
            )));
        }
        Ok(Self { shown, added: Some(added) })
    }
}

/// Corners of the ranges of θ; some of them where there are more than ten parameters.
fn corners(parameters: &[Parameter]) -> Vec<Vec<f64>> {
    let corner = |bits: usize| -> Vec<f64> {
        parameters.iter().enumerate().map(|(i, p)| p.range[bits >> (i % 10) & 1]).collect()
    };
    (0..1 << parameters.len().min(10)).map(corner).collect()
}

/// Line about the discretisation error: what [`sinew_fem::locking_at_centre`] found, `None` where it gave no answer.
fn discretisation(body: &Body, locking: Option<Option<&LockingWarning>>) -> String {
    let found = match locking {
        Some(Some(warning)) => {
            let lost = match warning.expected_share {
                share if share < 1.0 => format!("about {} %", digits(100.0 * share, 2)),
                _ => "most".into(),
            };
            format!("{lost} of the displacement is lost in the middle of the ranges")
        }
        Some(None) if !body.element().is_quadratic() => {
            "no locking was found in the middle of the ranges".into()
        }
        _ => "it was not checked; compare with a finer mesh (sinew solve --mesh FILE)".into(),
    };
    format!("discretisation error, not in the estimated one: {found}")
}

/// Lengths of displacements, on a scale from 0 to the largest.
fn displacement<'f>(
    unit: &str,
    surface: &Surface,
    checked: impl Iterator<Item = &'f Vec<f64>>,
) -> Quantity {
    let squares = |field: &Vec<f64>| -> Vec<f64> {
        let field = surface.of_field(field);
        field.as_chunks::<3>().0.iter().map(|u| u.iter().map(|x| x * x).sum()).collect()
    };
    let largest = checked.flat_map(squares).fold(0.0, f64::max).sqrt();
    Quantity {
        name: "Displacement".into(),
        unit: unit.into(),
        source: Source::Displacement,
        scale: [0.0, largest],
        ..Quantity::default()
    }
}

fn sliders(parameters: &[Parameter], pressures: &[PressureSurface]) -> Vec<Slider> {
    let pressures: Vec<_> = pressures.iter().map(|surface| surface.magnitude).collect();
    let slider = |(index, parameter): (usize, &Parameter)| Slider {
        name: parameter.name.clone(),
        unit: parameter.unit.name().into(),
        size: parameter.unit.in_scene(1.0),
        range: parameter.range,
        logarithmic: parameter.sampling == sinew_energy::Sampling::Log,
        pressure: pressures.contains(&Magnitude::Theta(index)),
    };
    parameters.iter().enumerate().map(slider).collect()
}

/// Unit that people read volumes in, and the size of a length³ in it.
pub(crate) fn volume_unit(length: &str) -> (String, f64) {
    if length == "mm" { ("ml".into(), 1e-3) } else { (format!("{length}³"), 1.0) }
}

/// Cavities with the ranges of their volumes.
fn cavities(body: &Body, surface: &Surface, fitted: &Sampled) -> ViewerEmulator {
    let (volume, volume_scale) = volume_unit(&body.units.length);
    let volumes: Vec<_> = fitted.fields.iter().map(|field| body.cavity_volumes(field)).collect();
    let cavity = |(index, cavity): (usize, &sinew_energy::Cavity)| {
        let own = || volumes.iter().map(|volumes| volume_scale * volumes[index]);
        let of_theta =
            |pressure: &&PressureSurface| pressure.nodes.contains(&cavity.parts[0].triangles[0][0]);
        let magnitude = body.pressures.iter().find(of_theta)?.magnitude;
        let is_its = |index: &usize| magnitude == Magnitude::Theta(*index);
        Some(ViewerCavity {
            name: cavity.name.clone(),
            parts: cavity
                .parts
                .iter()
                .map(|part| closed(part, cavity.sign, surface))
                .collect::<Option<_>>()?,
            pressure: (0..body.parameters.len()).find(is_its),
            range: [own().fold(f64::INFINITY, f64::min), own().fold(f64::NEG_INFINITY, f64::max)],
        })
    };
    let cavities = body.cavities.iter().enumerate().filter_map(cavity).collect();
    ViewerEmulator { cavities, volume, volume_scale, ..ViewerEmulator::default() }
}

/// A part of a cavity by nodes of the surface, with the cavity's sign in its field.
fn closed(part: &CavityPart, sign: f64, surface: &Surface) -> Option<Value> {
    let places = |nodes: &[usize]| -> Option<Vec<u32>> {
        nodes.iter().map(|&node| surface.place(node)).collect()
    };
    let planes = |planes: &[SymmetryPlane]| -> Option<Vec<Value>> {
        let plane = |&SymmetryPlane { node, normal, dual }: &SymmetryPlane| {
            Some(json!({ "node": surface.place(node)?, "normal": normal, "dual": dual }))
        };
        planes.iter().map(plane).collect()
    };
    let lid = |Lid { edges, chords, planes: own }: &Lid| {
        let edges = edges.iter().map(|edge| places(edge)).collect::<Option<Vec<_>>>()?;
        let ends = chords.iter().map(|(ends, _)| places(ends)).collect::<Option<Vec<_>>>()?;
        let weights: Vec<f64> = chords.iter().map(|(_, weight)| *weight).collect();
        Some(json!({ "edges": edges, "chords": ends, "weights": weights, "planes": planes(own)? }))
    };
    Some(json!({
        "triangles": Packed::u32(places(part.triangles.as_flattened())?),
        "weights": part.weights,
        "lids": part.lids.iter().map(lid).collect::<Option<Vec<_>>>()?,
        "planes": planes(&part.planes)?,
        "field": part.field.0.map(|row| row.map(|x| sign * x)),
    }))
}

fn facts(emulator: &Emulator<'_>, motion: &Motion) -> Vec<(String, String)> {
    let (body, record) = (emulator.body(), &emulator.record);
    let fact = |name: &str, value: String| (name.to_string(), value);
    let percent = |share: f64| format!("{} %", digits(100.0 * share, 2));
    let mut facts = vec![
        fact("mesh", format!("{} nodes, {} cells", body.nodes, body.cell_count())),
        fact("law", body.material.law().name.to_string()),
        fact("emulator", record.about.clone()),
    ];
    if let Some(errors) = &record.held_out {
        let [mean, largest] = [errors.relative.mean, errors.relative.max].map(percent);
        let told = format!("{mean} of the displacement in the mean, {largest} at most");
        facts.push(fact("emulator's error on held-out cases", told));
    }
    if let Some(added) = motion.added {
        let told = format!("{} of the displacement in the mean", percent(added));
        facts.push(fact("added by the page's regression", told));
    }
    facts
}
