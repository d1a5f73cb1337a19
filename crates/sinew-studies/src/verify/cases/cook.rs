//! Cook's membrane, at finite strain and linear elastic.

use crate::verify::case::{Band, Case, Effort, Formulation, Label, Rows};
use crate::verify::reference::published;
use crate::verify::solids::membrane::cook_membrane;
use crate::verify::solve::{displaced, mixed, scene};
use anyhow::Result;
use sinew_energy::laws::{LinearElastic, NeoHookeanShape, lame_from_young_poisson};
use sinew_energy::{Law, Load, Scene, Support};
use sinew_mesh::AnyMesh;

const THETA: [f64; 1] = [80.1938];
const BULK: f64 = 400_942.0;
/// Bulk modulus that the law of mixed elements keeps, almost zero: the field of pressure bears the rest.
const OWN_BULK: f64 = 1e-4;
/// Dead force per reference area, 100 per unit thickness.
const SHEAR: f64 = 6.25;
const UPPER: [f64; 3] = [48.0, 60.0, 0.0];
const MIDDLE: [f64; 3] = [48.0, 52.0, 0.0];

/// Squares per side, with the bands of the elements.
type Ladder = [(usize, Band)];

/// 0.3 % is wanted.
const MIXED: &Ladder = &[
    (4, Band::below(0.02)),
    (8, Band::below(0.006)),
    (16, Band::below(0.003)),
    (32, Band::below(0.001)),
];
const LINEAR: &Ladder = &[
    (8, Band::between(0.2, 0.35)),
    (16, Band::between(0.05, 0.1)),
    (32, Band::between(0.015, 0.035)),
];
const QUADRATIC: &Ladder =
    &[(8, Band::below(0.015)), (16, Band::below(0.006)), (32, Band::below(0.003))];
/// Too soft by up to a percent, whatever the mesh so far.
const PATCHES: &Ladder =
    &[(8, Band::below(0.01)), (16, Band::below(0.012)), (32, Band::below(0.01))];
/// Against the same elements on the same mesh in FEniCS: the seven digits that were printed.
const SAME_MESH: Band = Band::below(1e-7);

/// A tapered panel in plane strain, clamped at one side, sheared at the other, nearly incompressible.
pub(super) const CASE: Case = Case {
    name: "cook",
    title: "Cook's membrane, plane strain, finite strain, ν ≈ 0.4999",
    provenance: "FEniCS, quadratic–linear elements on crossed meshes: 6.9192 on 16×16, 6.9271 on 32×32 squares; 6.93 ± 0.01 in the limit. Bands of linear elements state how much they lock.",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    for &(squares, band) in effort.levels(3, MIXED) {
        let law = NeoHookeanShape.nearly_incompressible(OWN_BULK);
        let membrane = membrane(cook_membrane(squares).quadratic(), law, &THETA);
        let found = mixed(membrane, 1.0 / (BULK - OWN_BULK), &THETA)?;
        let label = label(Formulation::Mixed, squares);
        rows.relative(
            label.clone(),
            [found.at(UPPER)[1], published::COOK_LIMIT],
            band,
            found.cost,
        )?;
        let same = published::COOK_BY_MESH.iter().find(|(published, _)| *published == squares);
        if let Some((_, [upper, middle])) = same {
            for (point, name, reference) in
                [(UPPER, "u_y(48, 60)", upper), (MIDDLE, "u_y(48, 52)", middle)]
            {
                let label = Label { quantity: format!("{name} of FEniCS [mm]"), ..label.clone() };
                rows.relative(label, [found.at(point)[1], *reference], SAME_MESH, found.cost)?;
            }
        }
    }
    let compressible = (NeoHookeanShape.nearly_incompressible(BULK), &THETA[..]);
    let ladders =
        [(Formulation::P1, LINEAR), (Formulation::P2, QUADRATIC), (Formulation::FBar, PATCHES)];
    let ladders = ladders.map(|(formulation, ladder)| (formulation, effort.levels(2, ladder)));
    climb(rows, &ladders, &compressible, published::COOK_LIMIT)
}

/// E \[MPa\] and ν; the shear per area is [`SHEAR`] in MPa.
const YOUNG_POISSON: (f64, f64) = (70.0, 1.0 / 3.0);

/// The programs of the reference differ by ±0.12 %.
const SMALL_QUADRATIC: &Ladder = &[
    (4, Band::below(0.025)),
    (8, Band::below(0.01)),
    (16, Band::below(0.004)),
    (32, Band::below(0.0015)),
];
const SMALL_LINEAR: &Ladder =
    &[(8, Band::below(0.1)), (16, Band::below(0.04)), (32, Band::below(0.015))];

/// The membrane under a load that bends it by more than half its height, taken as if it were small.
pub(super) const SMALL: Case = Case {
    name: "cook-linear",
    title: "Cook's membrane, plane strain, linear elastic",
    provenance: "CalculiX, Code_Aster and Elmer as collected by solids4foam: 32.20–32.28 mm.",
    run: run_small,
};

fn run_small(effort: Effort, rows: &mut Rows) -> Result<()> {
    let theta = lame_from_young_poisson(YOUNG_POISSON.0, YOUNG_POISSON.1);
    let ladders = [
        (Formulation::P2, effort.levels(3, SMALL_QUADRATIC)),
        (Formulation::P1, effort.levels(2, SMALL_LINEAR)),
    ];
    climb(rows, &ladders, &(LinearElastic, &theta[..]), published::COOK_LINEAR)
}

/// Elements without a field of pressure, of a law with its θ.
fn climb<L: Law<0>>(
    rows: &mut Rows,
    ladders: &[(Formulation, &Ladder)],
    (law, theta): &(L, &[f64]),
    limit: f64,
) -> Result<()> {
    for &(formulation, ladder) in ladders {
        for &(squares, band) in ladder {
            let mesh = cook_membrane(squares);
            let mesh: AnyMesh = match formulation {
                Formulation::P2 => mesh.quadratic().into(),
                _ => mesh.into(),
            };
            let found = displaced(membrane(mesh, law.clone(), theta), formulation, theta)?;
            let pair = [found.at(UPPER)[1], limit];
            rows.relative(label(formulation, squares), pair, band, found.cost)?;
        }
    }
    Ok(())
}

fn membrane<L: Law<0>>(mesh: impl Into<AnyMesh>, law: L, theta: &[f64]) -> Scene {
    let loads = vec![Load::Traction { facets: "x_max".into(), value: [0.0, SHEAR, 0.0] }];
    scene(mesh, law, theta, loads, vec![Support::clamped("x_min")])
}

fn label(formulation: Formulation, squares: usize) -> Label {
    Label::new(formulation, format!("{squares}² squares"), "u_y(48, 60) [mm]")
}
