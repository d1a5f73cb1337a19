//! Thick sphere from compressible to nearly incompressible.

use super::radial::{OCTANT, octant, outward, rollers};
use crate::verify::case::{Band, Case, Effort, Formulation, Label, Rows};
use crate::verify::reference::{RADII, inflated_sphere};
use crate::verify::solids::shells::sphere_octant;
use crate::verify::solve::{displaced, pressed, scene};
use anyhow::Result;
use sinew_energy::laws::NeoHookean;
use sinew_mesh::AnyMesh;

const PRESSURE: f64 = 0.4;
/// λ over μ = 1.
const LAMES: [f64; 3] = [1.0, 49.0, 4999.0];
/// Layers and cells along an edge of the cube.
const MESHES: [[usize; 2]; 3] = [[2, 3], [3, 5], [4, 8]];

/// Known errors of one element for each λ and mesh, and the bands they must stay in.
type Known = ([[f64; 3]; 3], fn(f64) -> Band);

/// A quarter to both sides: what locks must be seen to lock.
fn around(error: f64) -> Band {
    Band::between(0.75 * error, 1.25 * error)
}

/// Up to a quarter above.
fn below(error: f64) -> Band {
    Band::below(1.25 * error)
}

const LINEAR: Known = ([[0.19, 0.10, 0.058], [0.51, 0.40, 0.35], [0.91, 0.80, 0.73]], around);
const HEXAHEDRA: Known = ([[0.11, 0.051, 0.029], [0.70, 0.50, 0.36], [1.0, 0.99, 0.99]], around);
const QUADRATIC: Known =
    ([[0.0047, 0.0011, 3.5e-4], [0.016, 0.0059, 0.0029], [0.028, 0.011, 0.007]], below);
const PATCHES: Known = ([[0.12, 0.055, 0.029], [0.13, 0.059, 0.031], [0.14, 0.059, 0.032]], below);
const HEXAHEDRA_AVERAGED: Known =
    ([[0.052, 0.023, 0.013], [0.054, 0.024, 0.013], [0.054, 0.024, 0.013]], below);

/// The locking ladder: how elements lose their deflection as λ/μ grows.
pub(super) const CASE: Case = Case {
    name: "sphere-locking",
    title: "Thick sphere at λ/μ = 1, 49 and 4999 under internal follower pressure: the locking ladder",
    provenance: "Radial equilibrium of thesis eq. (3.1) as a boundary value problem, own shooting by Runge and Kutta to \
         1e-12. Bands of linear elements state how much they lock.",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    for (formulation, (errors, band)) in [
        (Formulation::P1, LINEAR),
        (Formulation::FBar, PATCHES),
        (Formulation::P2, QUADRATIC),
        (Formulation::Q1, HEXAHEDRA),
        (Formulation::Q1FBar, HEXAHEDRA_AVERAGED),
    ] {
        for (lame, errors) in LAMES.into_iter().zip(errors) {
            let theta = [1.0, lame];
            let [exact, _] = inflated_sphere(lame, PRESSURE)?;
            for (&cells, error) in effort.levels(2, &MESHES).iter().zip(errors) {
                let wall = sphere_octant(RADII, cells);
                let mesh: AnyMesh = match formulation {
                    Formulation::P1 | Formulation::FBar => wall.tetrahedra().into(),
                    Formulation::P2 | Formulation::Mixed => wall.quadratic_tetrahedra().into(),
                    Formulation::Q1 | Formulation::Q1FBar => wall.hexahedra().into(),
                };
                let loads = pressed("inner", PRESSURE);
                let sphere = scene(mesh, NeoHookean, &theta, loads, rollers(&OCTANT));
                let found = displaced(sphere, formulation, &theta)?;
                let value = outward(&found, "inner", 3);
                let quantity = format!("displacement of the inner surface, λ/μ = {lame}");
                let label = Label::new(formulation, octant(cells), quantity);
                rows.relative(label, [value, exact], band(error), found.cost)?;
            }
        }
    }
    Ok(())
}
