//! Thick incompressible sphere under internal pressure.

use super::radial::{OCTANT, octant, rollers, surfaces};
use crate::verify::case::{Band, Case, Effort, Rows};
use crate::verify::reference::{RADII, outer_radius, sphere_pressure};
use crate::verify::solids::shells::sphere_octant;
use crate::verify::solve::{mixed, pressed, scene};
use anyhow::Result;
use sinew_energy::laws::NeoHookean;

/// μ, and a λ that no incompressible solution feels.
const THETA: [f64; 2] = [1.0, 10.0];
/// Deformed inner radius.
const INFLATED: f64 = 1.3;

/// Layers and cells along an edge of the cube, with the bands.
const LADDER: &[([usize; 2], Band)] = &[
    ([1, 2], Band::below(0.09)),
    ([2, 3], Band::below(0.01)),
    ([3, 4], Band::below(0.003)),
    ([4, 6], Band::below(0.001)),
];

/// An octant of an incompressible sphere, blown up by a third of its inner radius.
pub(super) const CASE: Case = Case {
    name: "sphere",
    title: "Thick incompressible sphere (1 : 2) under internal follower pressure",
    provenance: "Closed form p = μ[2/λ_b + 1/(2λ_b⁴) − 2/λ_a − 1/(2λ_a⁴)] of Green and Adkins.",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    let pressure = sphere_pressure(INFLATED);
    for &(cells, band) in effort.levels(2, LADDER) {
        let mesh = sphere_octant(RADII, cells).quadratic_tetrahedra();
        let supports = rollers(&OCTANT);
        let sphere = scene(mesh, NeoHookean, &THETA, pressed("inner", pressure), supports);
        let found = mixed(sphere, 0.0, &THETA)?;
        let setup = octant(cells);
        let exact = [INFLATED, outer_radius(3, INFLATED)];
        surfaces(rows, (setup, band), &found, (3, ""), exact)?;
    }
    Ok(())
}
