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

use crate::{Body, Result, parameters};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sinew_coordinates::{Motions, PrincipalDirections};
use sinew_energy::Barriers;
use sinew_fem::{SolveError, Solver};
use sinew_gnn::TrainingConfig;
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

/// Energy that outputs of one cost together about rest, in units of that of the linear response (by trial).
pub(crate) const FIRST_SHARE: f64 = 9.0;

/// The same about a solution, in units of the loads' work: over the parameter
/// range the energy varies by less than its own size, and smaller first steps are safer.
pub(crate) const ENERGY_SHARE: f64 = 0.05;

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

/// A state near to equilibrium at the centre of the parameter range: as much of the linear response, or of a `guess`, as has the least energy, made by
/// motions of the clusters, which turn where it would stretch; and some Newton steps from there.
pub(crate) fn nearby(
    solver: &mut Solver<'_>,
    topology: &Topology,
    guess: Vec<f64>,
    newton_steps: usize,
) -> Result<Vec<f64>> {
    /// Parts that are tried, the first and factor from one to the next: laws that stiffen leave little of the linear response.
    const PARTS: (f64, f64, i32) = (1.4, 0.75, 20);
    let body = solver.body();
    let (centre, rest) = (body.centre(), vec![0.0; 3 * body.nodes]);
    let response = solver.linear_response(&centre)?;
    let motions =
        Motions::about(&rest, topology, body, &centre)?.following(&[response, guess], body)?;
    let mut best = (f64::INFINITY, rest);
    let parts = (0..PARTS.2).map(|k| PARTS.0 * PARTS.1.powi(k));
    for part in parts.flat_map(|part| [[part, 0.0], [0.0, part]]) {
        let moved = motions.followed(&part, body)?;
        let energy = body.value(&moved, &centre);
        if energy < best.0 {
            best = (energy, moved);
        }
    }
    if newton_steps == 0 || !best.0.is_finite() {
        return Ok(best.1);
    }
    let steps = solver.newton_steps(&best.1, &centre, newton_steps)?;
    Ok(steps.into_iter().next_back().map_or(best.1, |step| step.displacement))
}

/// Motions that follow the parameters by themselves, so that a network learns what is beyond, and the derivatives of the solution as
/// features of the graph's nodes, in units of outputs: what fibres, loads and supports make of every part of the body.
///
/// First order are the derivatives at the motions' origin, one linear system each; second order is what one Newton step adds to first
/// order a deviation away in each parameter and each two of them, with the stiffness at the origin, which is factorised once. Where an
/// order goes too far, as exponential laws do, less is taken.
///
/// Returns these motions, and those of first order for the features.
pub(crate) fn following(
    solver: &mut Solver<'_>,
    motions: Motions,
    thetas: &[Vec<f64>],
) -> Result<(Motions, Motions)> {
    /// Distances in standardised parameters at which second order is taken, the next where the one before inverts a cell.
    const DEVIATIONS: [f64; 3] = [1.0, 0.5, 0.25];
    let body = solver.body();
    let (centre, scaling) = (body.centre(), parameters::scaling(body)?);
    let mut changes = solver.sensitivity_at(motions.origin(), &centre)?;
    for (change, slope) in changes.iter_mut().zip(scaling.slopes(&centre)) {
        change.iter_mut().for_each(|u| *u /= slope);
    }
    let first = motions.clone().following(&changes, body)?;
    for deviation in DEVIATIONS {
        if let Some(products) = second_order(&first, solver, deviation)? {
            changes.extend(products);
            let both = motions.clone().following(&changes, body)?;
            let count = body.parameters.len();
            // A body that no load moves has no amplitude.
            let in_proportion = motions.in_proportion(&changes, count, body).ok();
            return Ok((damped(&[Some(both), in_proportion], body, thetas)?, first));
        }
    }
    Ok((damped(&[Some(first.clone())], body, thetas)?, first))
}

/// As much of first and of second order, and in the form, as has the least energy at `thetas`. Energies count by their logarithm beyond a
/// small part of the work of the loads, so that no single set of parameters decides.
fn damped(forms: &[Option<Motions>], body: &Body, thetas: &[Vec<f64>]) -> Result<Motions> {
    /// Parts of both that are tried.
    const PARTS: [[f64; 2]; 6] =
        [[1.0, 1.0], [1.0, 0.6], [1.0, 0.3], [1.0, 0.0], [0.7, 0.0], [0.4, 0.0]];
    /// That part of the work.
    const PRECISE: f64 = 0.01;
    let of_first_order = body.parameters.len();
    let forms = forms.iter().flatten();
    let mut tried: Vec<(f64, Motions)> = forms
        .flat_map(|form| PARTS.map(|parts| (0.0, form.clone().damped(parts, of_first_order))))
        .collect();
    let (guarded, scaling) =
        (body.clone().with_barriers(Barriers::default()), parameters::scaling(body)?);
    let work = work(body, tried[0].1.origin());
    for theta in thetas {
        let at = scaling.standardise(theta)?;
        let energy = |(_, motions): &(f64, Motions)| -> Result<f64> {
            Ok(guarded.value(&motions.followed(&at, body)?, theta))
        };
        let energies: Vec<f64> = tried.par_iter().map(energy).collect::<Result<_>>()?;
        let least = energies.iter().copied().fold(f64::INFINITY, f64::min);
        // Loads that are zero at the centre do no work there: then the energies' own size is the scale.
        let scale = PRECISE * if work > 0.0 { work } else { least.abs() };
        // Where all are infinite, they say nothing.
        for ((loss, _), energy) in tried.iter_mut().zip(energies).filter(|_| least.is_finite()) {
            let excess = energy - least;
            *loss += if excess > 0.0 { (excess / scale).ln_1p() } else { 0.0 };
        }
    }
    tried.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    Ok(tried.swap_remove(0).1)
}

/// Changes of the displacement with the products of two standardised parameters, from states so far from the origin; `None` where first
/// order inverts a cell there.
fn second_order(
    first: &Motions,
    solver: &mut Solver<'_>,
    deviation: f64,
) -> Result<Option<Vec<Vec<f64>>>> {
    let body = solver.body();
    let (count, scaling) = (body.parameters.len(), parameters::scaling(body)?);
    let factor = 0.5 / deviation.powi(2);
    // Mean of what is missing at both ends of a direction: odd orders cancel.
    let mut missing = |axes: &[usize]| -> Result<Option<Vec<f64>>> {
        let mut sum = vec![0.0; 3 * body.nodes];
        for sign in [deviation, -deviation] {
            let at: Vec<f64> =
                (0..count).map(|p| if axes.contains(&p) { sign } else { 0.0 }).collect();
            let from = first.followed(&at, body)?;
            let theta = scaling.unstandardise(&at)?;
            match solver.step_with_held_stiffness(&from, &theta) {
                Ok(to) => {
                    let moved = to.iter().zip(&from);
                    sum.iter_mut()
                        .zip(moved)
                        .for_each(|(sum, (to, from))| *sum += factor * (to - from));
                }
                Err(SolveError::Inadmissible { .. }) => return Ok(None),
                Err(other) => return Err(other.into()),
            }
        }
        Ok(Some(sum))
    };
    // The origin need not be in equilibrium itself.
    let Some(at_origin) = missing(&[])? else { return Ok(None) };
    let mut squares = Vec::with_capacity(count);
    for p in 0..count {
        let Some(mut square) = missing(&[p])? else { return Ok(None) };
        square.iter_mut().zip(&at_origin).for_each(|(square, at_origin)| *square -= at_origin);
        squares.push(square);
    }
    let mut products = Vec::with_capacity(count * (count + 1) / 2);
    for p in 0..count {
        products.push(squares[p].clone());
        for q in p + 1..count {
            let Some(mut both) = missing(&[p, q])? else { return Ok(None) };
            let alone = squares[p].iter().zip(&squares[q]).zip(&at_origin);
            both.iter_mut().zip(alone).for_each(|(both, ((p, q), at_origin))| {
                *both -= p + q + at_origin;
            });
            products.push(both);
        }
    }
    Ok(Some(products))
}

/// Coordinates in which simulations at `thetas` differ beyond a polynomial in the parameters.
pub(crate) fn of_simulations(
    body: &Body,
    thetas: &[Vec<f64>],
    fields: &[Vec<f64>],
) -> Result<PrincipalDirections> {
    /// Between the spread of the simulations, which hides the small directions from the network, and equal sizes,
    /// which waste it on them (by trial).
    const POWER: f64 = 0.7;
    let scaling = parameters::scaling(body)?;
    let parameters: Vec<Vec<f64>> = thetas
        .iter()
        .map(|theta| scaling.standardise(theta))
        .collect::<std::result::Result<_, sinew_coordinates::CoordinateError>>(
    )?;
    let fields = fields.iter().map(Vec::as_slice);
    Ok(PrincipalDirections::following(fields, &parameters, POWER)?)
}

/// A displacement one Newton step nearer to equilibrium at the centre of the parameter range, or the same where it inverts a cell.
pub(crate) fn nearer(body: &Body, displacement: &[f64]) -> Result<Vec<f64>> {
    match Solver::new(body)?.newton_step(displacement, &body.centre()) {
        Ok(step) => Ok(step.displacement),
        Err(SolveError::Inadmissible { .. }) => Ok(displacement.to_vec()),
        Err(other) => Err(other.into()),
    }
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
pub(crate) fn work(body: &Body, displacement: &[f64]) -> f64 {
    let energy = body.value(displacement, &body.centre());
    body.load_value(displacement, &body.centre()).abs().max(energy.abs())
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
