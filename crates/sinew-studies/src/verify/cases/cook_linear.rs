//! Cook's membrane, linear elastic.

use super::cook::{Ladder, climb};
use crate::verify::case::{Band, Case, Effort, Formulation, Rows};
use crate::verify::reference::published;
use crate::verify::solids::membrane::cook_membrane;
use anyhow::Result;
use sinew_energy::laws::{LinearElastic, lame_from_young_poisson};

/// E \[MPa\] and ν; the shear per area is that of [`super::cook`], in MPa.
const YOUNG_POISSON: (f64, f64) = (70.0, 1.0 / 3.0);

/// The programs of the reference differ by ±0.12 %.
const QUADRATIC: &Ladder = &[
    (4, Band::below(0.025)),
    (8, Band::below(0.01)),
    (16, Band::below(0.004)),
    (32, Band::below(0.0015)),
];
const LINEAR: &Ladder = &[(8, Band::below(0.1)), (16, Band::below(0.04)), (32, Band::below(0.015))];

/// The membrane under a load that bends it by more than half its height, taken as if it were small.
pub(super) const CASE: Case = Case {
    name: "cook-linear",
    title: "Cook's membrane, plane strain, linear elastic",
    provenance: "CalculiX, Code_Aster and Elmer as collected by solids4foam: 32.20–32.28 mm.",
    run,
};

fn run(effort: Effort, rows: &mut Rows<'_>) -> Result<()> {
    let theta = lame_from_young_poisson(YOUNG_POISSON.0, YOUNG_POISSON.1);
    let (law, limit) = ((LinearElastic, &theta[..]), published::COOK_LINEAR);
    let quadratic = |squares| cook_membrane(squares).quadratic();
    climb(rows, Formulation::P2, effort.levels(3, QUADRATIC), &law, limit, quadratic)?;
    climb(rows, Formulation::P1, effort.levels(2, LINEAR), &law, limit, cook_membrane)
}
