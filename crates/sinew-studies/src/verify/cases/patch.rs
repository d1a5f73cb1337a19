//! Patch tests on distorted meshes.

use super::homogeneous::{ELEMENTS, Matrix, distorted};
use crate::verify::case::{Band, Case, Effort, Formulation, Label, Rows};
use crate::verify::solids::distort::Distort as _;
use crate::verify::solve::{Found, displaced, mixed, scene, with_moved_boundary};
use anyhow::Result;
use sinew_energy::laws::NeoHookean;
use sinew_mesh::{AnyMesh, rectangle_triangles};

/// Displacements \[edges of the cube\]: rounding, magnified by the condition of the stiffness.
const DISPLACEMENT: Band = Band::below(1e-10);
/// Forces on inner nodes in the exact state, relative to the largest one on the boundary.
const FORCE: Band = Band::below(1e-12);
/// A plane deformation and one in space.
const PLANE: Matrix = [[1.2, 0.3, 0.0], [0.1, 0.9, 0.0], [0.0, 0.0, 1.0]];
const SPACE: Matrix = [[1.2, 0.3, -0.1], [0.1, 0.9, 0.2], [0.05, -0.15, 1.1]];
/// μ and λ, compressible and nearly incompressible \[stress\].
const THETAS: [[f64; 2]; 2] = [[1.0, 1.0], [1.0, 1e3]];
/// Seed and amplitude of the distortion.
const DISTORTION: (u64, f64) = (11, 0.25);

/// The boundary of a cube or square follows `x = FX`: so must every inner node, on any mesh.
pub(super) const CASE: Case = Case {
    name: "patch",
    title: "Patch test: distorted meshes follow a homogeneous deformation of their boundary",
    provenance: "x = FX exactly; the constant stress of a homogeneous deformation is in equilibrium.",
    run,
};

fn run(effort: Effort, rows: &mut Rows) -> Result<()> {
    let cells = match effort {
        Effort::Quick => 3,
        Effort::Full => 5,
    };
    let (seed, amplitude) = DISTORTION;
    let triangles = rectangle_triangles([1.0; 2], [cells; 2]).distorted(seed, amplitude);
    for theta in THETAS {
        for formulation in ELEMENTS {
            compare(rows, formulation, distorted(formulation, cells, DISTORTION), &SPACE, theta)?;
        }
        compare(rows, Formulation::P1, triangles.clone(), &PLANE, theta)?;
        compare(rows, Formulation::P2, triangles.quadratic(), &PLANE, theta)?;
        let mesh = distorted(Formulation::Mixed, cells, DISTORTION);
        compare(rows, Formulation::Mixed, mesh, &SPACE, theta)?;
    }
    Ok(())
}

fn compare(
    rows: &mut Rows,
    formulation: Formulation,
    mesh: impl Into<AnyMesh>,
    f: &Matrix,
    theta: [f64; 2],
) -> Result<()> {
    let motion = |x: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|j| f[i][j] * x[j]).sum::<f64>() - x[i])
    };
    let (mesh, supports) = with_moved_boundary(mesh, motion);
    let scene = scene(mesh, NeoHookean, &theta, vec![], supports);
    let found = match formulation {
        // With a finite bulk modulus, so that the boundary may change the volume.
        Formulation::Mixed => mixed(scene, 1.0 / theta[1], &theta)?,
        _ => displaced(scene, formulation, &theta)?,
    };
    let Found { body, solution, cost } = found;
    let setup = format!("{}, λ/μ = {}", body.mesh.element().plural, theta[1] / theta[0]);
    let label = |quantity: &str| Label::new(formulation, setup.clone(), quantity);
    let exact: Vec<f64> = body.positions.iter().flat_map(|&x| motion(x)).collect();
    let error = largest_difference(&solution.displacement, &exact);
    rows.absolute(label("displacement off x = FX"), [error, 0.0], DISPLACEMENT, cost)?;
    if formulation == Formulation::Mixed {
        // Forces also depend on the field of pressure, which `value_and_gradient` leaves out.
        return Ok(());
    }

    let mut forces = vec![0.0; exact.len()];
    body.value_and_gradient(&exact, &theta, &mut forces);
    let largest = |held: bool| {
        let forces = forces.iter().zip(&body.prescribed);
        let chosen = forces.filter(|(_, p)| p.is_some() == held).map(|(force, _)| force.abs());
        chosen.fold(0.0, f64::max)
    };
    let unbalanced = largest(false) / largest(true);
    rows.absolute(label("unbalanced force at x = FX"), [unbalanced, 0.0], FORCE, cost)
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}
