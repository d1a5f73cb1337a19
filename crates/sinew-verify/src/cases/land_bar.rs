//! Problem 1 of Land et al. (2015).

use super::homogeneous::FRAME;
use crate::case::{Band, Case, Effort, Formulation, Label, Row, Rows};
use crate::reference::published;
use crate::solve::{Found, balance, displacement_at, lower, mixed, scene, with_directions};
use anyhow::Result;
use sinew_energy::laws::Guccione;
use sinew_energy::{FiniteElement, Load, Magnitude, Nodes, Scene, Support};
use sinew_mesh::{Mesh, box_tetrahedra};

/// A clamped bar with fibres along it, bent up by a follower pressure on its lower side.
pub(super) struct LandBar;

/// C \[kPa\], b_f, b_t, b_fs.
const THETA: [f64; 4] = [2.0, 8.0, 2.0, 4.0];
/// Bulk moduli \[kPa\] that stay with the displacements of mixed elements, whose field of pressure makes them
/// incompressible without, and of linear ones.
const MIXED_BULK: f64 = 0.0;
const BULK: f64 = 1000.0;
const PRESSURE: f64 = 0.004;
/// The point whose height is asked for \[mm\].
const POINT: [f64; 3] = [10.0, 0.5, 1.0];

/// Boxes with the bands of the elements on them.
type Ladder = [([usize; 3], Band)];

/// 4.16 ± 0.02 mm are wanted on at most 30×3×3 boxes.
const MIXED: &Ladder = &[
    ([10, 1, 1], Band::below(0.03)),
    ([20, 2, 2], Band::below(0.006)),
    ([30, 3, 3], Band::below(0.02 / published::LAND_BAR)),
];
/// Nearly the whole deflection of 3.16 of 4.16 mm is lost.
const LINEAR: &Ladder = &[
    ([10, 1, 1], Band::between(0.7, 0.76)),
    ([20, 2, 2], Band::between(0.68, 0.75)),
    ([30, 3, 3], Band::between(0.65, 0.73)),
];
const QUADRATIC: &Ladder = &[
    ([10, 1, 1], Band::below(0.12)),
    ([20, 2, 2], Band::below(0.035)),
    ([30, 3, 3], Band::below(0.02)),
];
const PATCHES: &Ladder = &[
    ([10, 1, 1], Band::between(0.2, 0.35)),
    ([20, 2, 2], Band::between(0.1, 0.2)),
    ([30, 3, 3], Band::between(0.06, 0.12)),
];
impl Case for LandBar {
    fn name(&self) -> &'static str {
        "land-bar"
    }

    fn title(&self) -> &'static str {
        "Land et al. (2015), problem 1: incompressible Guccione bar under follower pressure, loose rim"
    }

    fn provenance(&self) -> &'static str {
        "FEniCS, incompressible quadratic–linear elements: 4.14169 on 20×2×2, 4.15503 on 30×3×3 boxes, 4.16 ± 0.01 mm in \
         the limit; eleven groups of the paper: 4.0–4.2 mm. Bands of linear elements state how much they lock."
    }

    fn run(&self, effort: Effort, rows: &mut Rows<'_>) -> Result<()> {
        let mesh = |cells| box_tetrahedra([10.0, 1.0, 1.0], cells);
        for &(cells, band) in effort.levels(2, MIXED) {
            let bar = bar(mesh(cells).quadratic(), MIXED_BULK);
            let found = mixed(&bar, 0.0, &THETA)?;
            push(rows, Formulation::Mixed, cells, &bar.mesh, &found, band)?;
            same_mesh(rows, Formulation::Mixed, cells, &bar.mesh, &found)?;
        }
        for &(cells, band) in effort.levels(2, LINEAR) {
            let (mesh, found) = penalised(mesh(cells), Formulation::P1)?;
            push(rows, Formulation::P1, cells, &mesh, &found, band)?;
            same_mesh(rows, Formulation::P1, cells, &mesh, &found)?;
        }
        for &(cells, band) in effort.levels(2, QUADRATIC) {
            let (mesh, found) = penalised(mesh(cells).quadratic(), Formulation::P2)?;
            push(rows, Formulation::P2, cells, &mesh, &found, band)?;
            same_mesh(rows, Formulation::P2, cells, &mesh, &found)?;
        }
        for &(cells, band) in effort.levels(2, PATCHES) {
            let (mesh, found) = penalised(mesh(cells), Formulation::FBar)?;
            push(rows, Formulation::FBar, cells, &mesh, &found, band)?;
        }
        Ok(())
    }
}

fn bar<const N: usize>(
    mesh: Mesh<N>,
    bulk_modulus: f64,
) -> Scene<sinew_energy::NearlyIncompressible<Guccione>, 3, N> {
    let magnitude = Magnitude::Fixed(PRESSURE);
    let loads = vec![Load::Pressure { facets: "z_min".into(), magnitude }];
    let supports = vec![Support::clamped("x_min")];
    with_directions(
        scene(
            mesh,
            Guccione.nearly_incompressible(bulk_modulus).of_whole_strain(),
            &THETA,
            loads,
            supports,
        ),
        FRAME,
    )
}

/// Displacements alone, with ½κ(J − 1)². The rim of the loaded side is loose, so the patches of a bar without load
/// join the balance of the one with it.
fn penalised<const N: usize>(mesh: Mesh<N>, formulation: Formulation) -> Result<(Mesh<N>, Found)>
where
    Nodes<N>: FiniteElement<N>,
{
    let bar = bar(mesh, BULK);
    let mut body = bar.lower_follower()?;
    let unloaded = Scene { loads: Vec::new(), ..bar.clone() };
    body.body.patches = lower(&unloaded, formulation)?.patches;
    let (solution, cost) = balance(&body, &THETA)?;
    Ok((bar.mesh, Found { displacement: solution.displacement, cost }))
}

fn push<const N: usize>(
    rows: &mut Rows<'_>,
    formulation: Formulation,
    cells: [usize; 3],
    mesh: &Mesh<N>,
    found: &Found,
    band: Band,
) -> Result<()> {
    let height = POINT[2] + displacement_at(mesh, &found.displacement, POINT)[2];
    let setup = format!("{}×{}×{} boxes", cells[0], cells[1], cells[2]);
    let label = Label::new(formulation, setup, "z of (10, ½, 1) [mm]");
    rows.push(Row::relative(label, [height, published::LAND_BAR], band, found.cost)?);
    Ok(())
}

/// The row against the same elements on the same mesh in FEniCS, where there is such a run.
fn same_mesh<const N: usize>(
    rows: &mut Rows<'_>,
    formulation: Formulation,
    cells: [usize; 3],
    mesh: &Mesh<N>,
    found: &Found,
) -> Result<()> {
    let runs = published::LAND_BAR_BY_MESH.iter();
    for &(_, _, height) in runs.filter(|run| (run.0, run.1) == (formulation, cells)) {
        // Six digits were printed; the quadrature of quadratic elements is a choice.
        let band = Band::below(if formulation == Formulation::P1 { 1e-5 } else { 1e-3 });
        let value = POINT[2] + displacement_at(mesh, &found.displacement, POINT)[2];
        let setup = format!("{}×{}×{} boxes", cells[0], cells[1], cells[2]);
        let label = Label::new(formulation, setup, "z of (10, ½, 1) of FEniCS [mm]");
        rows.push(Row::relative(label, [value, height], band, found.cost)?);
    }
    Ok(())
}
