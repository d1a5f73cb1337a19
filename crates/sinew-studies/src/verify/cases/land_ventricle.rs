//! Problem 2 of Land et al. (2015).

use super::homogeneous::FRAME;
use super::radial::rollers;
use crate::verify::case::{Band, Case, Effort, Formulation, Label, Rows};
use crate::verify::reference::published;
use crate::verify::solve::{Found, mixed, pressed, scene};
use anyhow::Result;
use sinew_energy::laws::Guccione;
use sinew_energy::{Law, Solid, Strain, Support};
use sinew_mesh::{Sheet, TruncatedEllipsoid, Wall};

/// C \[kPa\], b_f, b_t, b_fs: isotropic.
const THETA: [f64; 4] = [10.0, 1.0, 1.0, 1.0];
/// \[kPa\]; the incompressible solution does not depend on it.
const BULK: f64 = 200.0;
/// \[kPa\]
const PRESSURE: f64 = 10.0;

/// Layers, cells around and along, with the bands; 0.5 % is wanted, better 0.3 %.
const LADDER: &[([usize; 3], Band)] = &[
    ([1, 16, 8], Band::below(0.005)),
    ([1, 24, 12], Band::below(0.003)),
    ([2, 32, 20], Band::below(0.003)),
];

/// A quarter of the idealised ventricle, isotropic, its base held, inflated by 10 kPa.
pub(super) const CASE: Case = Case {
    name: "land-ventricle",
    title: "Land et al. (2015), problem 2: incompressible ellipsoid inflated by 10 kPa, base held",
    provenance: "FEniCS on the axisymmetric problem in two dimensions, exact geometry, incompressible quadratic–linear elements, \
         14 853 unknowns: −26.612 and −28.280 ± 0.001 mm.",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    for &meshed in effort.levels(1, LADDER) {
        let mesh = quarter(TruncatedEllipsoid::LAND.wall(meshed.0)).quadratic_tetrahedra();
        let loads = pressed("endo", PRESSURE);
        let mut supports = rollers(&[("x_min", 0), ("y_min", 1)]);
        supports.push(Support::clamped("base"));
        let law = Solid { strain: Strain::Whole, ..Guccione.nearly_incompressible(BULK) };
        let material = law.along(vec![FRAME; mesh.cells.len()]);
        let ventricle = scene(mesh, material, &THETA, loads, supports);
        let found = mixed(ventricle, 0.0, &THETA)?;
        apexes(rows, Formulation::Mixed, meshed, &found, published::LAND_VENTRICLE)?;
    }
    Ok(())
}

/// The quarter x, y ≥ 0 of a wall, with the further sides `x_min` and `y_min`, the planes of symmetry.
fn quarter(mut wall: Wall) -> Wall {
    let Sheet { points, quads, .. } = std::mem::take(&mut wall.sheet);
    let is_inside = |node: &usize| points[*node][0] >= 0.0 && points[*node][1] >= 0.0;
    for quad in quads.into_iter().filter(|quad| quad.iter().all(is_inside)) {
        wall.sheet.quad(quad.map(|node| ([node as i64, 0, 0], points[node])));
    }
    wall.sides.push(("x_min", Box::new(|at| at[0] == 0.0)));
    wall.sides.push(("y_min", Box::new(|at| at[1] == 0.0)));
    wall
}

/// Heights of the apex on both surfaces.
pub(super) fn apexes(
    rows: &mut Rows,
    formulation: Formulation,
    (cells, band): ([usize; 3], Band),
    found: &Found,
    exact: [f64; 2],
) -> Result<()> {
    for (apex, height, exact) in [("inside", -17.0, exact[0]), ("outside", -20.0, exact[1])] {
        let value = height + found.at([0.0, 0.0, height])[2];
        let setup = format!("{} layers, {} around, {} along", cells[0], cells[1], cells[2]);
        let label = Label::new(formulation, setup, format!("z of the apex {apex} [mm]"));
        rows.relative(label, [value, exact], band, found.cost)?;
    }
    Ok(())
}
