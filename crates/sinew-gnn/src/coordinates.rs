//! Coordinates of the displacement in which networks are trained: the one place where they are chosen.
//!
//! Stretching a slender body costs about a million times the energy of bending it. An emulator trained on the energy in
//! plain displacements learns bending last, although bending makes most of the displacement. In [rigid motions](Motions) of
//! nested clusters, each scaled by its own energy, the Hessian of the energy is well conditioned, also when the body
//! rotates. All motions are then learned at one pace, in memory and time proportional to the body. Motions about rest need
//! one training only. Motions about one solution at the centre of the parameter range, predicted by a short first training
//! or simulated, leave less than half of the error.
//!
//! Training on simulations needs no stiffness. Simulations differ in few directions, and outputs in these directions have
//! the strains of simulations.

use crate::tensors::standardised;
use crate::{Result, TrainingConfig};
use serde::{Deserialize, Serialize};
use sinew_emulate::Body;
use sinew_emulate::coordinates::{Motions, PrincipalDirections};
use sinew_emulate::parts::{admissible, scaling, work};
use sinew_fem::{NewtonStep, SolveError, Solver};
use sinew_graph::Topology;

/// Coordinates of a network's outputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputCoordinates {
    /// Displacements, one scale per component (thesis).
    Components,
    /// The directions in which the simulations differ.
    Simulations,
    /// Rigid motions of clusters and displacements of nodes within them, about rest.
    Motions,
    /// Rigid motions about the prediction of a first, short training in [`OutputCoordinates::Motions`] for the centre, so without
    /// simulations.
    MotionsAfter(TrainingConfig),
}

/// Energy of unit outputs about rest [relative to the energy of the linear response], found by trial.
pub(crate) const FIRST_SHARE: f64 = 9.0;

/// Energy of unit outputs about a solution [relative to the loads' work]. Over the parameter range the energy varies by
/// less than its size, and small first steps are safer.
pub(crate) const ENERGY_SHARE: f64 = 0.05;

/// Motions about rest; `energy` is that of the linear response.
pub(crate) fn at_rest(body: &Body, topology: &Topology, energy: f64) -> Result<Motions> {
    let motions =
        Motions::about(&vec![0.0; 3 * body.nodes], &topology.clusters, body, &body.centre())?;
    Ok(motions.of_energy(FIRST_SHARE * energy)?)
}

/// Motions about a displacement, such as one that a first training predicts for the centre of the parameter range; `least_work` is that of
/// the loads.
pub(crate) fn at_anchor(
    body: &Body,
    topology: &Topology,
    anchor: &[f64],
    least_work: f64,
) -> Result<Motions> {
    let anchor = admissible(body, anchor);
    let motions = Motions::about(&anchor, &topology.clusters, body, &body.centre())?;
    Ok(motions.of_energy(ENERGY_SHARE * work(body, &anchor).max(least_work))?)
}

/// Coordinates in which simulations at `thetas` differ beyond a polynomial in the parameters.
pub(crate) fn of_simulations(
    body: &Body,
    thetas: &[Vec<f64>],
    fields: &[Vec<f64>],
) -> Result<PrincipalDirections> {
    /// Power of the standard deviations, found by trial. With 1 the network does not resolve the small directions; with 0
    /// it spends its capacity on them.
    const POWER: f64 = 0.7;
    let parameters = standardised(&scaling(body)?, thetas.iter().map(Vec::as_slice))?;
    let fields = fields.iter().map(Vec::as_slice);
    Ok(PrincipalDirections::about_trend(fields, &parameters, POWER)?)
}

/// A Newton step at the centre of the parameter range; none from a displacement that inverts a cell.
pub(crate) fn newton_step(body: &Body, displacement: &[f64]) -> Result<Option<NewtonStep>> {
    match Solver::new(body)?.newton_steps(displacement, &body.centre(), 1) {
        Ok(mut steps) => Ok(steps.pop()),
        Err(SolveError::Inadmissible { .. }) => Ok(None),
        Err(other) => Err(other.into()),
    }
}
