//! Cook's membrane at finite strain.

use crate::case::{Band, Case, Effort, Formulation, Label, Row, Rows};
use crate::reference::published;
use crate::solve::{Found, displaced, displacement_at, mixed, scene};
use anyhow::Result;
use sinew_energy::laws::NeoHookeanShape;
use sinew_energy::{Load, Scene, Support};
use sinew_mesh::{Mesh, cook_membrane};

/// A tapered panel in plane strain, clamped at one side, sheared at the other, nearly incompressible.
pub(super) struct Cook;

const THETA: [f64; 1] = [80.1938];
const BULK: f64 = 400_942.0;
/// What the law of mixed elements keeps of it, next to nothing: the field of pressure bears the rest.
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

impl Case for Cook {
    fn name(&self) -> &'static str {
        "cook"
    }

    fn title(&self) -> &'static str {
        "Cook's membrane, plane strain, finite strain, ν ≈ 0.4999"
    }

    fn provenance(&self) -> &'static str {
        "FEniCS, quadratic–linear elements on crossed meshes: 6.9192 on 16×16, 6.9271 on 32×32 squares; 6.93 ± 0.01 in the limit. Bands of linear elements state how much they lock."
    }

    fn run(&self, effort: Effort, rows: &mut Rows<'_>) -> Result<()> {
        for &(squares, band) in effort.levels(3, MIXED) {
            let scene = membrane(cook_membrane(squares).quadratic(), OWN_BULK);
            let found = mixed(&scene, 1.0 / (BULK - OWN_BULK), &THETA)?;
            push(rows, Formulation::Mixed, squares, &scene.mesh, &found, band)?;
            if let Some((_, same)) =
                published::COOK_BY_MESH.iter().find(|(published, _)| *published == squares)
            {
                let points = [(UPPER, 1, "u_y(48, 60)"), (MIDDLE, 1, "u_y(48, 52)")];
                for ((point, axis, name), reference) in points.into_iter().zip(same) {
                    let value = displacement_at(&scene.mesh, &found.displacement, point)[axis];
                    let setup = format!("{squares}² squares");
                    let label =
                        Label::new(Formulation::Mixed, setup, format!("{name} of FEniCS [mm]"));
                    rows.push(Row::relative(label, [value, *reference], SAME_MESH, found.cost)?);
                }
            }
        }
        for &(squares, band) in effort.levels(2, LINEAR) {
            let scene = membrane(cook_membrane(squares), BULK);
            let found = displaced(&scene, Formulation::P1, &THETA)?;
            push(rows, Formulation::P1, squares, &scene.mesh, &found, band)?;
        }
        for &(squares, band) in effort.levels(2, QUADRATIC) {
            let scene = membrane(cook_membrane(squares).quadratic(), BULK);
            let found = displaced(&scene, Formulation::P2, &THETA)?;
            push(rows, Formulation::P2, squares, &scene.mesh, &found, band)?;
        }
        for &(squares, band) in effort.levels(2, PATCHES) {
            let scene = membrane(cook_membrane(squares), BULK);
            let found = displaced(&scene, Formulation::FBar, &THETA)?;
            push(rows, Formulation::FBar, squares, &scene.mesh, &found, band)?;
        }
        Ok(())
    }
}

fn membrane<const N: usize>(
    mesh: Mesh<N>,
    bulk_modulus: f64,
) -> Scene<sinew_energy::NearlyIncompressible<NeoHookeanShape>, 0, N> {
    let loads = vec![Load::Traction { facets: "x_max".into(), value: [0.0, SHEAR, 0.0] }];
    let supports = vec![Support::clamped("x_min")];
    scene(mesh, NeoHookeanShape.nearly_incompressible(bulk_modulus), &THETA, loads, supports)
}

fn push<const N: usize>(
    rows: &mut Rows<'_>,
    formulation: Formulation,
    squares: usize,
    mesh: &Mesh<N>,
    found: &Found,
    band: Band,
) -> Result<()> {
    let value = displacement_at(mesh, &found.displacement, UPPER)[1];
    let label = Label::new(formulation, format!("{squares}² squares"), "u_y(48, 60) [mm]");
    rows.push(Row::relative(label, [value, published::COOK_LIMIT], band, found.cost)?);
    Ok(())
}
