//! Which body an emulator belongs to, in a few numbers.

use crate::Body;
use serde::{Deserialize, Serialize};

/// Numbers that tell a body from others: those of its mesh, supports and parameters, and its energy at a probe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Identity {
    nodes: usize,
    cells: usize,
    unknowns: usize,
    parameters: Vec<(String, [f64; 2])>,
    /// Root mean square of the positions [length].
    size: f64,
    /// Work of all forces and stresses along a probing displacement at the centre of the ranges.
    probe: f64,
}

/// Energies and positions that differ by less, relatively, are the same after a change of machine.
const ROUNDING: f64 = 1e-9;

pub(crate) fn of(body: &Body) -> Identity {
    let length = body.prescribed.len();
    let square: f64 = body.positions.as_flattened().iter().map(|x| x * x).sum();
    let size = (square / length.max(1) as f64).sqrt();
    // Small enough to invert no cell, and like nothing that a load or a fibre could hide from.
    let step = 1e-5 * size;
    let probe: Vec<f64> = (0..length).map(|i| step * (0.7 + 1.3 * i as f64).sin()).collect();
    let mut force = vec![0.0; length];
    body.value_and_gradient(&probe, &body.centre(), &mut force);
    Identity {
        nodes: body.nodes,
        cells: body.cell_count(),
        unknowns: body.free_degrees_of_freedom().len(),
        parameters: body.parameters.iter().map(|p| (p.name.clone(), p.range)).collect(),
        size,
        probe: crate::coordinates::dot(&force, &probe),
    }
}

/// What differs between a stored body and another one: the name, and how it is there and here.
pub(crate) fn difference(
    stored: &Identity,
    found: &Identity,
) -> Option<(&'static str, String, String)> {
    let close = |a: f64, b: f64| (a - b).abs() <= ROUNDING * a.abs().max(b.abs());
    let text = |value: &dyn std::fmt::Debug| format!("{value:?}");
    let pairs = [
        (
            "the number of nodes",
            stored.nodes == found.nodes,
            text(&stored.nodes),
            text(&found.nodes),
        ),
        (
            "the number of cells",
            stored.cells == found.cells,
            text(&stored.cells),
            text(&found.cells),
        ),
        (
            "the number of free components",
            stored.unknowns == found.unknowns,
            text(&stored.unknowns),
            text(&found.unknowns),
        ),
        (
            "the list of parameters",
            stored.parameters == found.parameters,
            text(&stored.parameters),
            text(&found.parameters),
        ),
        (
            "the size of the mesh",
            close(stored.size, found.size),
            text(&stored.size),
            text(&found.size),
        ),
        (
            "the work along a probing displacement",
            close(stored.probe, found.probe),
            text(&stored.probe),
            text(&found.probe),
        ),
    ];
    pairs.into_iter().find(|(_, same, _, _)| !same).map(|(what, _, a, b)| (what, a, b))
}
