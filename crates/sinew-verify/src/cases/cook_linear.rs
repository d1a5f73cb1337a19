//! Cook's membrane, linear elastic.

use crate::case::{Band, Case, Effort, Formulation, Label, Row, Rows};
use crate::reference::published;
use crate::solve::{displaced, displacement_at, scene};
use anyhow::Result;
use sinew_energy::laws::{LinearElastic, lame_from_young_poisson};
use sinew_energy::{FiniteElement, Load, Nodes, Support};
use sinew_mesh::{Mesh, cook_membrane};

/// The membrane under a load that bends it by more than half its height, taken as if it were small.
pub(super) struct CookLinear;

/// E \[MPa\] and ν.
const YOUNG_POISSON: (f64, f64) = (70.0, 1.0 / 3.0);
/// Shear per area \[MPa\].
const SHEAR: f64 = 6.25;

type Ladder = [(usize, Band)];

/// The programs of the reference differ by ±0.12 %.
const QUADRATIC: &Ladder = &[
    (4, Band::below(0.025)),
    (8, Band::below(0.01)),
    (16, Band::below(0.004)),
    (32, Band::below(0.0015)),
];
const LINEAR: &Ladder = &[(8, Band::below(0.1)), (16, Band::below(0.04)), (32, Band::below(0.015))];

impl Case for CookLinear {
    fn name(&self) -> &'static str {
        "cook-linear"
    }

    fn title(&self) -> &'static str {
        "Cook's membrane, plane strain, linear elastic"
    }

    fn provenance(&self) -> &'static str {
        "CalculiX, Code_Aster and Elmer as collected by solids4foam: 32.20–32.28 mm."
    }

    fn run(&self, effort: Effort, rows: &mut Rows<'_>) -> Result<()> {
        climb(rows, Formulation::P2, effort.levels(3, QUADRATIC), |n| {
            cook_membrane(n).quadratic()
        })?;
        climb(rows, Formulation::P1, effort.levels(2, LINEAR), cook_membrane)
    }
}

fn climb<const N: usize>(
    rows: &mut Rows<'_>,
    formulation: Formulation,
    ladder: &Ladder,
    mesh: impl Fn(usize) -> Mesh<N>,
) -> Result<()>
where
    Nodes<N>: FiniteElement<N>,
{
    let theta = lame_from_young_poisson(YOUNG_POISSON.0, YOUNG_POISSON.1);
    for &(squares, band) in ladder {
        let loads = vec![Load::Traction { facets: "x_max".into(), value: [0.0, SHEAR, 0.0] }];
        let supports = vec![Support::clamped("x_min")];
        let membrane = scene(mesh(squares), LinearElastic, &theta, loads, supports);
        let found = displaced(&membrane, formulation, &theta)?;
        let value = displacement_at(&membrane.mesh, &found.displacement, [48.0, 60.0, 0.0])[1];
        let label = Label::new(formulation, format!("{squares}² squares"), "u_y(48, 60) [mm]");
        rows.push(Row::relative(label, [value, published::COOK_LINEAR], band, found.cost)?);
    }
    Ok(())
}
