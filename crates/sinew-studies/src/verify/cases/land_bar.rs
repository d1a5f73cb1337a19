//! Problem 1 of Land et al. (2015).

use super::boxes::{Boxes, box_mesh, boxes};
use super::homogeneous::FRAME;
use crate::verify::case::{Band, Case, Effort, Formulation, Label, Rows};
use crate::verify::reference::published;
use crate::verify::solve::{Found, displaced, mixed, pressed, scene};
use anyhow::Result;
use sinew_energy::laws::Guccione;
use sinew_energy::{Law, Scene, Solid, Strain, Support};
use sinew_mesh::AnyMesh;

/// C \[kPa\], b_f, b_t, b_fs.
const THETA: [f64; 4] = [2.0, 8.0, 2.0, 4.0];
/// Bulk moduli \[kPa\]: next to nothing for mixed elements, whose field of pressure makes them incompressible without,
/// and that of displacements alone.
const MIXED_BULK: f64 = 1e-3;
const BULK: f64 = 1000.0;
const PRESSURE: f64 = 0.004;
/// The point whose height is asked for \[mm\].
const POINT: [f64; 3] = [10.0, 0.5, 1.0];

/// 4.16 ± 0.02 mm are wanted on at most 30×3×3 boxes.
const MIXED: &Boxes = &[
    ([10, 1, 1], Band::below(0.03)),
    ([20, 2, 2], Band::below(0.006)),
    ([30, 3, 3], Band::below(0.02 / published::LAND_BAR)),
];
/// Nearly the whole deflection of 3.16 of 4.16 mm is lost.
const LINEAR: &Boxes = &[
    ([10, 1, 1], Band::between(0.7, 0.76)),
    ([20, 2, 2], Band::between(0.68, 0.75)),
    ([30, 3, 3], Band::between(0.65, 0.73)),
];
const QUADRATIC: &Boxes = &[
    ([10, 1, 1], Band::below(0.12)),
    ([20, 2, 2], Band::below(0.035)),
    ([30, 3, 3], Band::below(0.02)),
];
const PATCHES: &Boxes = &[
    ([10, 1, 1], Band::between(0.2, 0.35)),
    ([20, 2, 2], Band::between(0.1, 0.2)),
    ([30, 3, 3], Band::between(0.06, 0.12)),
];

/// A clamped bar with fibres along it, bent up by a follower pressure on its lower side.
pub(super) const CASE: Case = Case {
    name: "land-bar",
    title: "Land et al. (2015), problem 1: incompressible Guccione bar under follower pressure, loose rim",
    provenance: "FEniCS, incompressible quadratic–linear elements: 4.14169 on 20×2×2, 4.15503 on 30×3×3 boxes, 4.16 ± 0.01 mm in \
         the limit; eleven groups of the paper: 4.0–4.2 mm. Bands of linear elements state how much they lock.",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    for (formulation, quick, ladder) in [
        (Formulation::Mixed, 2, MIXED),
        (Formulation::P1, 2, LINEAR),
        (Formulation::P2, 2, QUADRATIC),
        (Formulation::FBar, 2, PATCHES),
    ] {
        for &meshed in effort.levels(quick, ladder) {
            let mesh = box_mesh([10.0, 1.0, 1.0], meshed.0, formulation);
            let found = match formulation {
                Formulation::Mixed => mixed(bar(mesh, MIXED_BULK), 0.0, &THETA)?,
                // Displacements alone, with ½κ(J − 1)². The rim of the loaded side is loose.
                _ => displaced(bar(mesh, BULK).loose_rims(), formulation, &THETA)?,
            };
            push(rows, formulation, meshed, &found)?;
        }
    }
    Ok(())
}

fn bar(mesh: AnyMesh, bulk_modulus: f64) -> Scene {
    let loads = pressed("z_min", PRESSURE);
    let supports = vec![Support::clamped("x_min")];
    let law = Solid { strain: Strain::Whole, ..Guccione.nearly_incompressible(bulk_modulus) };
    let material = law.along(vec![FRAME; mesh.cell_count()]);
    scene(mesh, material, &THETA, loads, supports)
}

/// Beside the limit, and beside the same elements on the same mesh in FEniCS where there is such a run.
fn push(
    rows: &mut Rows,
    formulation: Formulation,
    (cells, band): ([usize; 3], Band),
    found: &Found,
) -> Result<()> {
    let height = POINT[2] + found.at(POINT)[2];
    let label = Label::new(formulation, boxes(cells), "z of (10, ½, 1) [mm]");
    rows.relative(label, [height, published::LAND_BAR], band, found.cost)?;
    let runs = published::LAND_BAR_BY_MESH.iter();
    for &(_, _, published) in runs.filter(|run| (run.0, run.1) == (formulation, cells)) {
        // Six digits were printed; the quadrature of quadratic elements is a choice.
        let band = Band::below(if formulation == Formulation::P1 { 1e-5 } else { 1e-3 });
        let label = Label::new(formulation, boxes(cells), "z of (10, ½, 1) of FEniCS [mm]");
        rows.relative(label, [height, published], band, found.cost)?;
    }
    Ok(())
}
