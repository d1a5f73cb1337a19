//! Coordinates of the displacement in which networks are trained: the one place where they are chosen.
//!
//! A strain energy weighs stretching a million times heavier than bending, so an emulator that is
//! trained on the energy in plain displacements learns the bending last, and bending is what
//! moves. In [rigid motions](Motions) of nested clusters, each scaled by the energy that it costs alone, the energy is nearly round,
//! and stays so when the body turns: all motions are learned at one pace, in memory and time proportional to the body. They
//! can be taken about rest, so that one training needs nothing else; about one solution for the centre of the
//! parameter range, predicted by a first, short training or simulated, they leave less than half of the error.
//!
//! Training on simulations needs no stiffness: the directions in which they differ are few, and
//! outputs in these directions have the strains of simulations.

use crate::{Body, Result};
use serde::{Deserialize, Serialize};
use sinew_fem::Solver;
use sinew_gnn::{Motions, PrincipalDirections, TrainingConfig};
use sinew_graph::Topology;

/// What the outputs of a network mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coordinates {
    /// Displacements, one scale per component (thesis).
    Components,
    /// The directions in which the simulations differ.
    Simulations,
    /// Rigid motions of clusters and displacements of nodes within them, about rest.
    Motions,
    /// The same about a simulation near the centre of the parameter range.
    MotionsOfSimulation,
    /// The same about what a first, short training in [`Coordinates::Motions`] predicts for the centre, so without
    /// simulations.
    MotionsAfter(TrainingConfig),
}

impl Coordinates {
    /// Whether virtual nodes are read too, which then form clusters up to the whole body.
    pub(crate) fn are_motions(&self) -> bool {
        !matches!(self, Self::Components | Self::Simulations)
    }
}

/// Energy that outputs of one cost together about rest, in units of that of the linear response: measured in
/// docs/design.md.
const FIRST_SHARE: f64 = 9.0;

/// The same about a solution, in units of the loads' work: over the parameter
/// range the energy varies by less than its own size, and smaller first steps are safer.
const ENERGY_SHARE: f64 = 0.05;

/// Motions about rest; `energy` is that of the linear response.
pub(crate) fn at_rest(body: &Body, topology: &Topology, energy: f64) -> Result<Motions> {
    let motions = Motions::about(&vec![0.0; 3 * body.nodes], topology, body, &body.centre())?;
    Ok(motions.of_energy(FIRST_SHARE * energy)?)
}

/// Motions about a displacement, such as one that a first training predicts for the centre of the parameter range.
pub(crate) fn at_anchor(body: &Body, topology: &Topology, anchor: &[f64]) -> Result<Motions> {
    let anchor = admissible(body, anchor);
    let motions = Motions::about(&anchor, topology, body, &body.centre())?;
    Ok(motions.of_energy(ENERGY_SHARE * work(body, &anchor))?)
}

/// Coordinates in which simulations differ.
pub(crate) fn of_simulations(fields: &[Vec<f64>]) -> Result<PrincipalDirections> {
    /// Between the spread of the simulations, which hides the small directions from the network, and equal sizes,
    /// which waste it on them: measured in docs/design.md.
    const POWER: f64 = 0.7;
    Ok(PrincipalDirections::of(fields.iter().map(Vec::as_slice), POWER)?)
}

/// Energy that a Newton step from `displacement` would gain at the centre of the parameter range, relative to the
/// work of the loads: how far it is from equilibrium.
pub(crate) fn excess(body: &Body, displacement: &[f64]) -> Result<f64> {
    let step = Solver::new(body)?.newton_step(displacement, &body.centre())?;
    Ok(0.5 * step.energy_norm.powi(2) / work(body, displacement))
}

/// A displacement that inverts a cell is halved until it does not.
pub(crate) fn admissible(body: &Body, displacement: &[f64]) -> Vec<f64> {
    let (mut anchor, centre) = (displacement.to_vec(), body.centre());
    while !body.value(&anchor, &centre).is_finite() {
        anchor.iter_mut().for_each(|u| *u *= 0.5);
    }
    anchor
}

/// Work of the loads, or the energy where there are none to speak of [energy].
fn work(body: &Body, displacement: &[f64]) -> f64 {
    let energy = body.value(displacement, &body.centre());
    body.load_value(displacement, &body.centre()).abs().max(energy.abs())
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
