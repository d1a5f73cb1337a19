//! Solving for the states of a patient.

use super::anchor::{Anchor, Solved};
use super::states::{PatientStates, Result, StateError};
use crate::setting::Entry;
use rayon::prelude::*;
use sinew_energy::Body;
use sinew_fem::{Options, Solution, Unload, UnloadOptions, Unloaded};
use sinew_num::difference;

/// Iterations from a predicted body at rest at most. If it is farther off, the search from the image is as fast.
const NEAR: usize = 12;

/// Displacements from the image come in this order: image, rest, then phases.
pub(super) const FIRST_PHASE: usize = 2;

/// A body with the loads of its states.
pub(super) struct Parts<'p> {
    pub image: &'p Body,
    pub unload: Unload<'p>,
    /// The image, where it is at rest.
    pub at_rest: Option<Body>,
    pub parameters: Vec<String>,
    /// Entries of θ of the body in the image.
    pub image_entries: Vec<Entry>,
    /// Names of the phases.
    pub phases: Vec<String>,
    /// Entries of θ of the body in the phases.
    pub phase_entries: Vec<Vec<Entry>>,
    /// Unbalanced forces of states \[relative\].
    pub accuracy: f64,
}

/// The body at rest with its motion from the image.
struct Rest {
    body: Body,
    motion: Vec<f64>,
    found: Option<Unloaded>,
}

impl<'p> Parts<'p> {
    /// Checks θ of the patient, and of the body in each state.
    pub(super) fn check(&self, theta: &[f64]) -> Result<()> {
        let (given, needed) = (theta.len(), self.parameters.len());
        if given != needed {
            return Err(StateError::Length { given, needed });
        }
        let states = std::iter::once(("image", &self.image_entries))
            .chain(self.phases.iter().map(String::as_str).zip(&self.phase_entries));
        for (state, entries) in states {
            let values = values(entries, theta);
            let checked = self.image.check_theta(&values);
            checked.map_err(|source| StateError::Theta { state: state.into(), source })?;
        }
        Ok(())
    }

    /// The body at rest and its phases in their order, up to the first without a stable equilibrium, and why that has none.
    pub(super) fn reached(
        &self,
        theta: &[f64],
        anchor: Option<&Anchor<'_>>,
    ) -> Result<(PatientStates, Option<StateError>)> {
        let unload = anchor.map_or(&self.unload, |anchor| &anchor.unload);
        let mut unload = unload.fresh().map_err(sinew_fem::UnloadError::from)?;
        let mut solve = Solve { parts: self, unload: &mut unload, theta };
        let predicted = anchor.map(|anchor| anchor.predict(theta));
        let rest = solve.rest(predicted.as_deref())?;
        let (phases, end) = solve.phases_reached(&rest, predicted.as_deref());
        Ok((PatientStates::of(rest, phases, Vec::new()), end))
    }

    pub(super) fn solve(
        &self,
        theta: &[f64],
        anchor: Option<&Anchor<'_>>,
        derivatives: bool,
    ) -> Result<PatientStates> {
        let unload = anchor.map_or(&self.unload, |anchor| &anchor.unload);
        let mut unload = unload.fresh().map_err(sinew_fem::UnloadError::from)?;
        Solve { parts: self, unload: &mut unload, theta }.states(anchor, derivatives)
    }

    /// States with slopes at the first θ and at those of the others that have them, to predict more from.
    pub(super) fn anchor(&self, thetas: &[Vec<f64>], near: Option<&Anchor>) -> Option<Anchor<'p>> {
        let (first, others) = thetas.split_first()?;
        let mut unload = self.unload.fresh().ok()?;
        let mut solve = Solve { parts: self, unload: &mut unload, theta: first };
        let states = solve.states(near, true).ok()?;
        let mut centre = Anchor::new(vec![Solved::new(first, states)], unload);
        let solve = |theta: &Vec<f64>| {
            self.check(theta).ok()?;
            Some(Solved::new(theta, self.solve(theta, Some(&centre), true).ok()?))
        };
        let more: Vec<_> = others.par_iter().map(solve).collect();
        let solved =
            std::mem::take(&mut centre.solved).into_iter().chain(more.into_iter().flatten());
        Some(Anchor::new(solved.collect(), centre.unload))
    }
}

impl PatientStates {
    fn of(rest: Rest, phases: Vec<Solution>, slopes: Vec<Vec<Vec<f64>>>) -> Self {
        let mut moved = vec![vec![0.0; rest.motion.len()], rest.motion.clone()];
        moved.extend(phases.iter().map(|phase| -> Vec<f64> {
            phase.displacement.iter().zip(&rest.motion).map(|(u, w)| u + w).collect()
        }));
        let Rest { body, found, .. } = rest;
        Self { rest: body, unloaded: found, phases, moved, slopes }
    }
}

/// All states at one θ.
struct Solve<'a, 'u> {
    parts: &'a Parts<'a>,
    unload: &'a mut Unload<'u>,
    theta: &'a [f64],
}

impl Solve<'_, '_> {
    fn states(&mut self, anchor: Option<&Anchor>, derivatives: bool) -> Result<PatientStates> {
        let predicted = anchor.map(|anchor| anchor.predict(self.theta));
        let rest = self.rest(predicted.as_deref())?;
        let phases = match &predicted {
            Some(predicted) => {
                let phase = |(index, predicted): (usize, &Vec<f64>)| {
                    self.phase(&rest, index, &difference(predicted, &rest.motion))
                };
                let predicted = predicted[FIRST_PHASE..].iter().enumerate();
                predicted.map(phase).collect::<Result<Vec<_>, _>>()?
            }
            None => self.phases_in_order(&rest)?,
        };
        phases.iter().enumerate().try_for_each(|(index, found)| self.stable(index, found))?;
        let slopes = if derivatives { self.slopes(&rest, &phases)? } else { Vec::new() };
        Ok(PatientStates::of(rest, phases, slopes))
    }

    fn stable(&self, index: usize, found: &Solution) -> Result<()> {
        let (phase, negative_pivots) = (self.parts.phases[index].clone(), found.negative_pivots);
        if negative_pivots > 0 {
            return Err(StateError::Unstable { phase, negative_pivots });
        }
        Ok(())
    }

    fn rest(&mut self, predicted: Option<&[Vec<f64>]>) -> Result<Rest> {
        let Self { parts, unload, theta } = self;
        if let Some(body) = &parts.at_rest {
            let motion = vec![0.0; 3 * parts.image.nodes];
            return Ok(Rest { body: body.clone(), motion, found: None });
        }
        let values = values(&parts.image_entries, theta);
        let near = predicted.and_then(|predicted| {
            let (iterations, accuracy) = (NEAR, parts.accuracy);
            let options = UnloadOptions { iterations, accuracy, load: None, ..Default::default() };
            unload.solve_near(&predicted[1], &values, &options).ok()
        });
        let found = near.map_or_else(|| unload.solve(&values, &UnloadOptions::default()), Ok)?;
        let (body, motion) = (found.rest.clone(), found.motion.clone());
        Ok(Rest { body, motion, found: Some(found) })
    }

    /// The phases one after the other, each from the state whose loads are nearest.
    fn phases_in_order(&self, rest: &Rest) -> Result<Vec<Solution>> {
        let thetas = self.phase_thetas();
        let mut known = self.known(rest);
        let mut found: Vec<Option<Solution>> = vec![None; thetas.len()];
        for _ in 0..thetas.len() {
            let open = (0..thetas.len()).filter(|&index| found[index].is_none());
            let pairs = open.flat_map(|phase| (0..known.len()).map(move |start| (phase, start)));
            let apart = |&(phase, start): &(usize, usize)| apart(&thetas[phase], &known[start].0);
            let nearest = pairs.min_by(|a, b| apart(a).total_cmp(&apart(b)));
            let Some((phase, start)) = nearest else { break };
            let solved = self.phase(rest, phase, &known[start].1)?;
            known.push((thetas[phase].clone(), solved.displacement.clone()));
            found[phase] = Some(solved);
        }
        Ok(found.into_iter().flatten().collect())
    }

    /// The phases in the order in which they were added, each from its prediction or the state whose loads are nearest, up to the first
    /// without a stable equilibrium, and why it has none.
    fn phases_reached(
        &self,
        rest: &Rest,
        predicted: Option<&[Vec<f64>]>,
    ) -> (Vec<Solution>, Option<StateError>) {
        let (mut known, mut found) = (self.known(rest), Vec::new());
        for (index, theta) in self.phase_thetas().into_iter().enumerate() {
            let nearest = || {
                let pairs = known.iter().map(|(at, u)| (apart(&theta, at), u));
                pairs.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(Vec::new, |(_, u)| u.clone())
            };
            let near = predicted.map(|all| difference(&all[FIRST_PHASE + index], &rest.motion));
            let solved = self.phase(rest, index, &near.unwrap_or_else(nearest));
            match solved.and_then(|solved| self.stable(index, &solved).map(|()| solved)) {
                Ok(solved) => {
                    known.push((theta, solved.displacement.clone()));
                    found.push(solved);
                }
                Err(error) => return (found, Some(error)),
            }
        }
        (found, None)
    }

    /// θ of the body in each phase.
    fn phase_thetas(&self) -> Vec<Vec<f64>> {
        self.parts.phase_entries.iter().map(|entries| values(entries, self.theta)).collect()
    }

    /// θ of the body with displacements from rest that are known before any phase: without loads, and in the image.
    fn known(&self, rest: &Rest) -> Vec<(Vec<f64>, Vec<f64>)> {
        let Self { parts, theta, .. } = self;
        let image = values(&parts.image_entries, theta);
        let of_law = parts.image.material.parameters().len();
        let mut unloaded = image.clone();
        unloaded[of_law..].fill(0.0);
        let mut known = vec![(unloaded, vec![0.0; rest.motion.len()])];
        if parts.at_rest.is_none() {
            known.push((image, rest.motion.iter().map(|w| -w).collect()));
        }
        known
    }

    fn phase(&self, rest: &Rest, index: usize, near: &[f64]) -> Result<Solution> {
        let parts = self.parts;
        let values = values(&parts.phase_entries[index], self.theta);
        let options = Options { minimum_accuracy: parts.accuracy, ..Options::default() };
        let found = self.unload.loaded(&rest.body, near, &values, &options);
        found.map_err(|source| StateError::Phase { phase: parts.phases[index].clone(), source })
    }

    /// Derivatives of the places of all states in each parameter.
    fn slopes(&mut self, rest: &Rest, phases: &[Solution]) -> Result<Vec<Vec<Vec<f64>>>> {
        let Self { parts, unload, theta } = self;
        let still = vec![vec![0.0; rest.motion.len()]; parts.parameters.len()];
        let at = |state: &str| {
            let state = state.to_owned();
            move |source| StateError::Slopes { state, source }
        };
        let of_rest = match &rest.found {
            None => Vec::new(),
            Some(found) => {
                let directions = directions(&parts.image_entries, theta);
                unload.sensitivity_along(found, &directions).map_err(at("rest"))?
            }
        };
        let mut slopes =
            vec![still.clone(), if of_rest.is_empty() { still } else { of_rest.clone() }];
        for ((name, entries), found) in parts.phases.iter().zip(&parts.phase_entries).zip(phases) {
            let along = directions(entries, theta);
            let places = unload.loaded_slopes(&rest.body, found, &along, &of_rest);
            slopes.push(places.map_err(at(name))?);
        }
        Ok(slopes)
    }
}

/// θ of the body.
pub(super) fn values(entries: &[Entry], theta: &[f64]) -> Vec<f64> {
    entries.iter().map(|entry| entry.value(theta)).collect()
}

/// Derivatives of θ of the body in each parameter.
fn directions(entries: &[Entry], theta: &[f64]) -> Vec<Vec<f64>> {
    let along = |parameter| entries.iter().map(|entry| entry.slope(theta, parameter)).collect();
    (0..theta.len()).map(along).collect()
}

/// Distance between two θ, each entry relative to its size.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let part = |(a, b): (&f64, &f64)| {
        let size = a.abs().max(b.abs());
        if size > 0.0 { ((a - b) / size).powi(2) } else { 0.0 }
    };
    a.iter().zip(b).map(part).sum()
}
