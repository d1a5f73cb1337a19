//! Thick incompressible cylinder under internal pressure.

use super::boxes::boxes;
use super::radial::{rollers, surfaces};
use crate::verify::case::{Band, Case, Effort, Rows};
use crate::verify::reference::{RADII, outer_radius, tube_pressure};
use crate::verify::solids::shells::cylinder_quarter;
use crate::verify::solve::{mixed, pressed, scene};
use anyhow::Result;
use sinew_energy::Support;
use sinew_energy::laws::NeoHookean;
use sinew_mesh::{AnyMesh, Mesh, rectangle_triangles};
use std::f64::consts::FRAC_PI_2;

const THETA: [f64; 2] = [1.0, 10.0];
const INFLATED: f64 = 1.3;

const PLANE: &[([usize; 2], Band)] =
    &[([2, 4], Band::below(0.01)), ([4, 8], Band::below(0.002)), ([8, 16], Band::below(0.001))];
const SOLID: &[([usize; 2], Band)] = &[([2, 4], Band::below(0.003)), ([4, 8], Band::below(5e-4))];

/// A quarter of a long tube, as triangles in plane strain and as tetrahedra between two sliding planes.
pub(super) const CASE: Case = Case {
    name: "cylinder",
    title: "Thick incompressible cylinder (1 : 2) in plane strain under internal follower pressure",
    provenance: "Closed form p = μ[ln(B/A) − ln(b/a) + ½(a² − A²)(a⁻² − b⁻²)].",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    let planes = [("x_min", 0), ("y_min", 1)];
    for &(cells, band) in effort.levels(2, PLANE) {
        let setup = format!("{}×{} quads in plane strain", cells[0], cells[1]);
        compare(rows, ring(cells), rollers(&planes), (setup, band))?;
    }
    let slides = [("x_min", 0), ("y_min", 1), ("z_min", 2), ("z_max", 2)];
    for &([layers, around], band) in effort.levels(1, SOLID) {
        let wall = cylinder_quarter(RADII, 0.5, [layers, around, 1]);
        let setup = boxes([layers, around, 1]);
        compare(rows, wall.quadratic_tetrahedra(), rollers(&slides), (setup, band))?;
    }
    Ok(())
}

/// A quarter of a ring; its sides have the names of [`cylinder_quarter`].
fn ring([layers, around]: [usize; 2]) -> Mesh<6> {
    let mut mesh = rectangle_triangles([1.0; 2], [layers, around]).quadratic();
    mesh.map_points(|[depth, turn, _]| {
        let radius = (1.0 - depth) * RADII[0] + depth * RADII[1];
        // Both are sines, so that the planes of symmetry are met exactly.
        [radius * (FRAC_PI_2 * (1.0 - turn)).sin(), radius * (FRAC_PI_2 * turn).sin(), 0.0]
    });
    let sides = [("x_min", "inner"), ("x_max", "outer"), ("y_min", "y_min"), ("y_max", "x_min")];
    let renamed =
        |old: &str| sides.iter().find(|side| side.0 == old).map_or(old, |side| side.1).to_string();
    mesh.node_sets = mesh.node_sets.into_iter().map(|(name, set)| (renamed(&name), set)).collect();
    mesh.facet_sets =
        mesh.facet_sets.into_iter().map(|(name, set)| (renamed(&name), set)).collect();
    mesh
}

fn compare(
    rows: &mut Rows,
    mesh: impl Into<AnyMesh>,
    supports: Vec<Support>,
    meshed: (String, Band),
) -> Result<()> {
    let loads = pressed("inner", tube_pressure(INFLATED));
    let tube = scene(mesh, NeoHookean, &THETA, loads, supports);
    let found = mixed(tube, 0.0, &THETA)?;
    let kind =
        if found.body.mesh.element().dimension == 2 { ", triangles" } else { ", tetrahedra" };
    surfaces(rows, meshed, &found, (2, kind), [INFLATED, outer_radius(2, INFLATED)])
}
