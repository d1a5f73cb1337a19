//! Fingerprint of the body that an emulator belongs to, in a few numbers.

use crate::Body;
use serde::{Deserialize, Serialize};
use sinew_energy::{Parameter, Sampling};
use sinew_num::dot;

/// Numbers that tell a body from others: those of its mesh, supports and parameters, and its energy at a probe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Identity {
    nodes: usize,
    cells: usize,
    unknowns: usize,
    /// Units of length and of stress.
    units: [String; 2],
    pub(crate) parameters: Vec<Axis>,
    known: Vec<(String, f64)>,
    /// Root mean square of the positions [length].
    size: f64,
    /// Checksum of the supports: sum over the prescribed degrees of freedom, each with its own weight, direction and
    /// displacement \[relative to the size\].
    held: f64,
    /// Work of all forces and stresses along a probing displacement at the centre of the ranges.
    probe: f64,
    /// Work along it with every parameter at another share of its range: at the centre loads may be zero, and equal parameters may change
    /// places. Files of version 0.1.0 have none.
    #[serde(default)]
    aside: Option<f64>,
}

/// Name, range, unit and scale of a parameter. If one of them differs, the input of an emulator differs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Axis {
    pub(crate) name: String,
    pub(crate) range: [f64; 2],
    pub(crate) unit: String,
    pub(crate) logarithmic: bool,
}

/// A parameter whose range is in a unit.
pub(crate) fn axis(p: &Parameter, unit: &str) -> Axis {
    let logarithmic = p.sampling == Sampling::Log;
    Axis { name: p.name.clone(), range: p.range, unit: unit.into(), logarithmic }
}

/// Relative tolerance of the comparison: rounding differs between machines.
const ROUNDING: f64 = 1e-9;
/// Golden ratio, whose multiples are far from each other modulo one.
const GOLDEN: f64 = 0.618_033_988_749_895;

pub(crate) fn of(body: &Body) -> Identity {
    let length = body.prescribed.len();
    let square: f64 = body.positions.as_flattened().iter().map(|x| x * x).sum();
    let size = (square / length.max(1) as f64).sqrt();
    // Small enough to invert no cell, and orthogonal to no load or fibre.
    let step = 1e-5 * size;
    let probe: Vec<f64> = (0..length).map(|i| step * (0.7 + 1.3 * i as f64).sin()).collect();
    let work = |theta: &[f64]| {
        let mut force = vec![0.0; length];
        body.value_and_gradient(&probe, theta, &mut force);
        dot(&force, &probe)
    };
    let share = |number: usize| (0.37 + GOLDEN * number as f64).fract();
    let aside = body.parameters.iter().enumerate().map(|(i, p)| p.at_share(share(i)));
    let aside: Vec<f64> = aside.collect();
    let held = |(i, prescribed): (usize, &Option<f64>)| {
        prescribed.map(|u| body.frames.component(i, &probe) / step * (1.0 + u / size))
    };
    let parameters = body.parameters.iter().map(|p| axis(p, p.unit.of_scene(&body.units)));
    Identity {
        nodes: body.nodes,
        cells: body.cell_count(),
        unknowns: body.free_degrees_of_freedom().len(),
        units: [body.units.length.clone(), body.units.stress.clone()],
        parameters: parameters.collect(),
        known: body.known.clone(),
        size,
        held: body.prescribed.iter().enumerate().filter_map(held).sum(),
        probe: work(&body.centre()),
        aside: Some(work(&aside)),
    }
}

const PARAMETERS: &str = "the list of parameters";

/// First difference between a stored body and another one: its name and both values.
pub(crate) fn difference(
    stored: &Identity,
    found: &Identity,
) -> Option<(&'static str, String, String)> {
    let texts = |body: &Identity| {
        let known = body.known.iter().map(|(name, value)| format!("{name} = {value}"));
        [
            ("the number of nodes", body.nodes.to_string()),
            ("the number of cells", body.cells.to_string()),
            ("the number of free components", body.unknowns.to_string()),
            ("the units", body.units.join(" and ")),
            (PARAMETERS, listed(&body.parameters)),
            ("the list of known parameters", known.collect::<Vec<_>>().join(", ")),
        ]
    };
    let numbers = [
        ("the size of the mesh", stored.size, found.size),
        ("what supports prescribe, and where", stored.held, found.held),
        ("the work along a probing displacement", stored.probe, found.probe),
    ];
    let aside = stored.aside.zip(found.aside);
    let aside = aside.map(|(a, b)| ("the work beside the centre of the ranges", a, b));
    let texts = texts(stored).into_iter().zip(texts(found)).map(|((what, a), (_, b))| (what, a, b));
    let numbers = numbers.into_iter().chain(aside).filter(|(_, a, b)| !close(*a, *b));
    let numbers = numbers.map(|(what, a, b)| (what, format!("{a:e}"), format!("{b:e}")));
    let axes = same_axes(&stored.parameters, &found.parameters);
    let differs = |(what, a, b): &(_, String, String)| a != b && !(axes && *what == PARAMETERS);
    texts.filter(differs).chain(numbers).next()
}

/// Whether parameters agree, their ranges to rounding errors: those of other units are converted.
pub(crate) fn same_axes(stored: &[Axis], found: &[Axis]) -> bool {
    let same = |(a, b): (&Axis, &Axis)| {
        (&a.name, &a.unit, a.logarithmic) == (&b.name, &b.unit, b.logarithmic)
            && a.range.iter().zip(b.range).all(|(&a, b)| close(a, b))
    };
    stored.len() == found.len() && stored.iter().zip(found).all(same)
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= ROUNDING * a.abs().max(b.abs())
}

/// Parameters in words.
pub(crate) fn listed(parameters: &[Axis]) -> String {
    let one = |Axis { name, range: [low, high], unit, logarithmic }: &Axis| {
        let scale = if *logarithmic { "logarithmic" } else { "linear" };
        format!("{name} from {low} to {high} {unit} ({scale})")
    };
    parameters.iter().map(one).reduce(|all, next| all + ", " + &next).unwrap_or("none".into())
}
