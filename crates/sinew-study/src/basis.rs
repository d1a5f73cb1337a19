//! Coordinates of the displacement in which an emulator is trained.
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

use crate::train::Body;
use anyhow::Result;
use sinew_fem::Solver;
use sinew_gnn::OutputBasis;

/// Part of the potential energy that outputs of size one span about the anchor: over the parameter
/// range the energy varies by less than its own size, and smaller first steps are safer.
const ENERGY_SHARE: f64 = 0.05;

/// Coordinates for the first training: `u = c |K|^(−¼) z` at rest, with `c` such that the linear response has
/// outputs of size one.
///
/// # Errors
/// A stiffness that cannot be formed.
pub fn at_rest(body: &Body) -> Result<OutputBasis> {
    let mut solver = Solver::new(&body.exact)?;
    let rest = vec![0.0; body.linear_response.len()];
    let map = solver.inverse_stiffness_power(&rest, &body.centre, 0.25)?;
    let back = solver.inverse_stiffness_power(&rest, &body.centre, -0.25)?;
    let size = rest.len();
    let outputs = back.chunks_exact(size).map(|row| dot(row, &body.linear_response));
    let square: f64 = outputs.map(|z| z * z).sum();
    let scale = (square / solver.unknowns() as f64).sqrt();
    Ok(OutputBasis::new(rest, &scaled(map, scale))?)
}

/// Coordinates about a displacement.
#[derive(Clone, Debug)]
pub struct Anchored {
    /// The coordinates.
    pub basis: OutputBasis,
    /// Energy that a Newton step from the displacement would gain, relative to the work of the loads: how far it is
    /// from equilibrium at the centre of the parameter range.
    pub excess: f64,
}

/// Coordinates for the second training, about `anchor`: a displacement \[mm\] that the first one predicts for the
/// centre of the parameter range. One that inverts a cell is halved until it does not.
///
/// # Errors
/// A stiffness that cannot be formed.
pub fn at_anchor(body: &Body, anchor: &[f64]) -> Result<Anchored> {
    let mut anchor = anchor.to_vec();
    let mut energy = body.exact.value(&anchor, &body.centre);
    while !energy.is_finite() {
        anchor.iter_mut().for_each(|u| *u *= 0.5);
        energy = body.exact.value(&anchor, &body.centre);
    }
    let mut solver = Solver::new(&body.exact)?;
    let map = solver.inverse_stiffness_power(&anchor, &body.centre, 0.5)?;
    let work = dot(&body.exact.nodal_force, &anchor).abs().max(energy.abs());
    let mut force = vec![0.0; anchor.len()];
    body.exact.value_and_gradient(&anchor, &body.centre, &mut force);
    let weighed = map.chunks_exact(anchor.len()).map(|row| dot(row, &force));
    let excess = 0.5 * weighed.map(|w| w * w).sum::<f64>() / work;
    let scale = (2.0 * ENERGY_SHARE * work / solver.unknowns() as f64).sqrt();
    Ok(Anchored { basis: OutputBasis::new(anchor, &scaled(map, scale))?, excess })
}

/// Coordinates in which simulations differ.
///
/// # Errors
/// Simulations that are all the same.
pub fn of_simulations(fields: &[Vec<f64>]) -> Result<OutputBasis> {
    /// Between the spread of the simulations, which hides the small directions from the network, and equal sizes,
    /// which waste it on them: measured in docs/design.md.
    const POWER: f64 = 0.7;
    Ok(OutputBasis::principal(fields.iter().map(Vec::as_slice), POWER)?)
}

/// The simulation whose parameters are nearest to the centre of the range, by ratio.
pub fn nearest_to_centre<'a>(body: &Body, fields: &'a [Vec<f64>]) -> Option<&'a [f64]> {
    let distance = |theta: &[f64]| -> f64 {
        theta.iter().zip(&body.centre).map(|(a, b)| (a / b).ln().powi(2)).sum()
    };
    let pairs = body.thetas.iter().zip(fields);
    let nearest = pairs.min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
    nearest.map(|(_, field)| &field[..])
}

/// The root `|K|^½` of the stiffness at `anchor` and the centre of the parameter range: what errors are weighed
/// by in the energy norm.
///
/// # Errors
/// A stiffness that cannot be formed.
pub fn stiffness_root(body: &Body, anchor: &[f64]) -> Result<Vec<f64>> {
    Ok(Solver::new(&body.exact)?.inverse_stiffness_power(anchor, &body.centre, -0.5)?)
}

fn scaled(mut map: Vec<f64>, factor: f64) -> Vec<f64> {
    map.iter_mut().for_each(|entry| *entry *= factor);
    map
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
