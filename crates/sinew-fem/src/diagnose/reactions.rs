//! Reactions of the supports.

use crate::SolveError;
use crate::elements::check::check_fields;
use crate::elements::followers::Followers;
use crate::elements::supports::held_part;
use nalgebra::Vector3;
use sinew_energy::{Body, PressureForm, PressureSurface};
use sinew_num::Mat3;
use std::slice::from_ref;

/// Forces of the supports on the body \[stress·length²\], for each of [`held_sets`]; `pressure` is that of mixed elements, else empty.
///
/// A pressed surface loads its rim with pressure times area; where a lid closes it, with the pressure on the lid as well.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// # use sinew_fem::{Options, Solver, reactions};
/// # use sinew_mesh::box_tetrahedra;
/// # let parameter = |name: &str| Parameter::log(name, "kPa", 1.0..=1e6);
/// # let scene = Scene::new(box_tetrahedra([100.0, 10.0, 10.0], [12, 4, 5]), NeoHookean).parameter(parameter("mu"))
/// #     .parameter(parameter("lambda")).load(Load::BodyForce([0.0, 0.0, -9.8e-3])).support(Support::clamped("x_min"));
/// let (beam, theta) = (scene.lower()?, [75.0, 75.0]);
/// let solution = Solver::new(&beam)?.solve(&theta, &Options::default())?;
/// let found = reactions(&beam, &solution.displacement, &[], &theta)?;
/// assert!(found.len() == 1 && (found[0][2] - 98.0).abs() < 1e-6); // its weight, at x_min
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Arrays of other lengths than the body's.
pub fn reactions(
    body: &Body,
    displacement: &[f64],
    pressure: &[f64],
    theta: &[f64],
) -> Result<Vec<[f64; 3]>, SolveError> {
    check_fields(body, displacement, pressure, theta)?;
    let total = forces(body, displacement, pressure, theta);
    let sum = |nodes: &[usize]| {
        nodes.iter().fold(Vector3::zeros(), |sum, &node| sum + force_on(body, node, &total)).into()
    };
    Ok(held_sets(body).map(|(_, nodes)| sum(nodes)).collect())
}

/// Node sets of a body's mesh whose nodes are all held, with their names.
pub fn held_sets(body: &Body) -> impl Iterator<Item = (&String, &Vec<usize>)> {
    let all_held = |nodes: &[usize]| !nodes.is_empty() && nodes.iter().all(|&n| held(body, n));
    body.mesh.node_sets().iter().filter(move |(_, nodes)| all_held(nodes))
}

/// Whether a support holds a node; the third direction of a body in two dimensions does not count.
fn held(body: &Body, node: usize) -> bool {
    (0..body.element().dimension).any(|i| body.prescribed[3 * node + i].is_some())
}

/// Force of the supports on a node.
fn force_on(body: &Body, node: usize, forces: &[f64]) -> Vector3<f64> {
    let held = held_part(body, node, [0, 1, 2].map(|i| forces[3 * node + i]));
    Vector3::from_fn(|i, _| if i < body.element().dimension { held[i] } else { 0.0 })
}

/// Whether the potential of a surface is that of its pressure only while its rim is held: its derivative at the rim is not the
/// force there, and depends on the origin of coordinates.
fn is_open_follower(surface: &PressureSurface) -> bool {
    surface.triangles != Some(PressureForm::Thesis) && surface.lids.is_empty()
}

/// Forces on every degree of freedom: derivative of the energy, with pressures themselves in place of their potentials, and with
/// the field of pressure; at prescribed ones it is the reaction.
fn forces(body: &Body, displacement: &[f64], pressure: &[f64], theta: &[f64]) -> Vec<f64> {
    let mut total = vec![0.0; displacement.len()];
    body.value_and_gradient(displacement, theta, &mut total);
    Followers::new(&body.followers).add_forces(displacement, theta, &mut total);
    for surface in body.pressures.iter().filter(|surface| is_open_follower(surface)) {
        let mut derivative = vec![0.0; displacement.len()];
        surface.value_and_add_gradient(displacement, theta, &mut derivative);
        total.iter_mut().zip(derivative).for_each(|(total, derivative)| *total -= derivative);
        Followers::new(from_ref(surface)).add_forces(displacement, theta, &mut total);
    }
    if let Some(field) = &body.pressure_field {
        // ∫ p cof F ∇N dV
        let law = |point: usize, h: &Mat3<f64>| {
            let (p, cofactor) = (field.at(point, pressure), h.plus_identity().cofactors());
            Some((0.0, Mat3::from_fn(|i, j| p * cofactor[i][j])))
        };
        body.add_stress_forces(displacement, law, &mut total);
    }
    total
}
