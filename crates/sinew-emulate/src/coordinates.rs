//! Coordinates of the displacement in which networks are trained: the one place where they are chosen.
//!
//! A strain energy weighs stretching a million times heavier than bending, so an emulator that is
//! trained on the energy in plain displacements learns the bending last, and bending is what
//! moves. In coordinates `z` with `u = u₀ + c |K(u₀)|^(−½) z`, K the stiffness at `u₀`, the energy near `u₀` is
//! `½ c² zᵀz`: all motions are learned at one pace. That needs a `u₀` near the solutions, for the stiffness of
//! a slender body turns with it: one simulation, or without any a first, short training, whose own outputs are
//! scaled by the stiffness at rest to the power −¼, a compromise that large rotations tolerate.
//!
//! Training on simulations needs no stiffness: the directions in which they differ are few, and
//! outputs in these directions have the strains of simulations.

use crate::{Body, Result};
use serde::{Deserialize, Serialize};
use sinew_fem::Solver;
use sinew_gnn::{OutputBasis, TrainingConfig};

/// What the outputs of a network mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coordinates {
    /// Displacements, one scale per component (thesis).
    Components,
    /// The directions in which the simulations differ.
    Simulations,
    /// Those in which the energy is round about a simulation near the centre of the parameter range.
    StiffnessOfSimulation,
    /// The same about what a first, short training predicts for the centre, so without simulations.
    StiffnessAfter(TrainingConfig),
}

/// Part of the potential energy that outputs of size one span about the anchor: over the parameter
/// range the energy varies by less than its own size, and smaller first steps are safer.
const ENERGY_SHARE: f64 = 0.05;

/// Coordinates for the first training: `u = c |K|^(−¼) z` at rest, with `c` such that the linear response has
/// outputs of size one.
pub(crate) fn at_rest(body: &Body, linear_response: &[f64]) -> Result<OutputBasis> {
    let mut solver = Solver::new(body)?;
    let (rest, centre) = (vec![0.0; linear_response.len()], body.centre());
    let map = solver.inverse_stiffness_power(&rest, &centre, 0.25)?;
    let back = solver.inverse_stiffness_power(&rest, &centre, -0.25)?;
    let size = rest.len();
    let outputs = back.chunks_exact(size).map(|row| dot(row, linear_response));
    let square: f64 = outputs.map(|z| z * z).sum();
    let scale = (square / solver.unknowns() as f64).sqrt();
    Ok(OutputBasis::new(rest, &scaled(map, scale))?)
}

/// Coordinates about a displacement, such as one that a first training predicts for the centre of the parameter range.
pub(crate) fn at_anchor(body: &Body, anchor: &[f64]) -> Result<OutputBasis> {
    let anchor = admissible(body, anchor);
    let mut solver = Solver::new(body)?;
    let centre = body.centre();
    let map = solver.inverse_stiffness_power(&anchor, &centre, 0.5)?;
    let scale = (2.0 * ENERGY_SHARE * work(body, &anchor) / solver.unknowns() as f64).sqrt();
    Ok(OutputBasis::new(anchor, &scaled(map, scale))?)
}

/// Coordinates in which simulations differ.
pub(crate) fn of_simulations(fields: &[Vec<f64>]) -> Result<OutputBasis> {
    /// Between the spread of the simulations, which hides the small directions from the network, and equal sizes,
    /// which waste it on them: measured in docs/design.md.
    const POWER: f64 = 0.7;
    Ok(OutputBasis::principal(fields.iter().map(Vec::as_slice), POWER)?)
}

/// The root `|K|^½` of the stiffness at `anchor` and the centre of the parameter range: what errors are weighed
/// by in the energy norm.
pub(crate) fn stiffness_root(body: &Body, anchor: &[f64]) -> Result<Vec<f64>> {
    Ok(Solver::new(body)?.inverse_stiffness_power(anchor, &body.centre(), -0.5)?)
}

/// Energy that a Newton step from `displacement` would gain at the centre of the parameter range, relative to the
/// work of the loads: how far it is from equilibrium.
pub(crate) fn excess(body: &Body, displacement: &[f64]) -> Result<f64> {
    let step = Solver::new(body)?.newton_step(displacement, &body.centre())?;
    Ok(0.5 * step.energy_norm.powi(2) / work(body, displacement))
}

/// A displacement that inverts a cell is halved until it does not.
fn admissible(body: &Body, displacement: &[f64]) -> Vec<f64> {
    let (mut anchor, centre) = (displacement.to_vec(), body.centre());
    while !body.value(&anchor, &centre).is_finite() {
        anchor.iter_mut().for_each(|u| *u *= 0.5);
    }
    anchor
}

/// Work of the dead loads, or the energy where there are none to speak of [energy].
fn work(body: &Body, displacement: &[f64]) -> f64 {
    let energy = body.value(displacement, &body.centre());
    dot(&body.nodal_force, displacement).abs().max(energy.abs())
}

fn scaled(mut map: Vec<f64>, factor: f64) -> Vec<f64> {
    map.iter_mut().for_each(|entry| *entry *= factor);
    map
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
