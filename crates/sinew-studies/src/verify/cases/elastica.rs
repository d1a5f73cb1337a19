//! A slender cantilever in large bending.

use super::boxes::{Boxes, box_mesh, boxes};
use crate::verify::case::{Band, Case, Effort, Formulation, Label, Rows};
use crate::verify::reference::Elastica;
use crate::verify::solve::{displaced, scene};
use anyhow::Result;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Support};

const LENGTH: f64 = 100.0;
/// μ and λ: Young's modulus 1, Poisson's ratio 0.
const THETA: [f64; 2] = [0.5, 0.0];
/// Bending stiffness EI of the unit square.
const BENDING: f64 = 1.0 / 12.0;

/// Error that remains on the finest mesh: shear, stretching and the clamp's finite thickness, about (1/100)²,
/// and the strain of bending squared.
const QUADRATIC: &Boxes = &[
    ([20, 1, 1], Band::below(0.006)),
    ([40, 1, 1], Band::below(5e-4)),
    ([80, 1, 1], Band::below(2e-4)),
];
const LINEAR: &Boxes = &[
    ([50, 1, 1], Band::between(0.5, 1.0)),
    ([100, 2, 2], Band::between(0.2, 1.0)),
    ([200, 4, 4], Band::between(0.05, 0.5)),
];
const HEXAHEDRA: &Boxes =
    &[([100, 1, 1], Band::between(0.1, 0.2)), ([200, 2, 2], Band::between(0.02, 0.07))];

/// A bar of 100 × 1 × 1 without lateral contraction bends like the elastica.
pub(super) const CASE: Case = Case {
    name: "elastica",
    title: "Slender cantilever (1 : 100) against the elastica: dead load at the tip and along the bar",
    provenance: "Own shooting solution of EIθ″ = −Q cos θ. Bands of linear elements state how much they lock in bending.",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    for load in [Elastica::TipLoad(5.0), Elastica::UniformLoad(10.0)] {
        for (formulation, quick, ladder) in [
            (Formulation::P2, 2, QUADRATIC),
            (Formulation::P1, 1, LINEAR),
            (Formulation::Q1, 0, HEXAHEDRA),
        ] {
            for &meshed in effort.levels(quick, ladder) {
                compare(rows, load, formulation, meshed)?;
            }
        }
    }
    Ok(())
}

fn compare(
    rows: &mut Rows,
    load: Elastica,
    formulation: Formulation,
    (cells, band): ([usize; 3], Band),
) -> Result<()> {
    let [along, across] = load.tip()?;
    // The unit square turns forces into forces per area, and forces per length into body forces.
    let (name, force) = match load {
        Elastica::TipLoad(size) => {
            let value = [0.0, 0.0, -size * BENDING / LENGTH.powi(2)];
            (format!("PL²/EI = {size}"), Load::Traction { facets: "x_max".into(), value })
        }
        Elastica::UniformLoad(size) => {
            let density = [0.0, 0.0, -size * BENDING / LENGTH.powi(3)];
            (format!("qL³/EI = {size}"), Load::BodyForce(density))
        }
    };
    let mesh = box_mesh([LENGTH, 1.0, 1.0], cells, formulation);
    let bar = scene(mesh, NeoHookean, &THETA, vec![force], vec![Support::clamped("x_min")]);
    let found = displaced(bar, formulation, &THETA)?;
    let tip = found.at([LENGTH, 0.5, 0.5]);
    let label = |what: &str| Label::new(formulation, boxes(cells), format!("{what}, {name}"));
    let deflection = [-tip[2] / LENGTH, across];
    rows.relative(label("deflection over length"), deflection, band, found.cost)?;
    let distance = [1.0 + tip[0] / LENGTH, along];
    rows.relative(label("distance over length"), distance, band, found.cost)
}
