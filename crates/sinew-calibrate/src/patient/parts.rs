//! The states of a patient at one θ, and solving for them.

use super::anchor::{Anchor, Solved};
use crate::observable::ForwardError;
use crate::setting::Entry;
use sinew_energy::{Body, ThetaError};
use sinew_fem::{Options, Solution, SolveError, Unload, UnloadError, UnloadOptions, Unloaded};
use sinew_num::{difference, in_parallel};
use thiserror::Error;

/// Iterations from a predicted body at rest at most. If it is farther off, the search from the image is as fast.
const NEAR: usize = 12;

/// Displacements from the image come in this order: image, rest, then phases.
const REST: usize = 1;
const FIRST_PHASE: usize = 2;

/// The unloaded body and its phases at one θ.
#[derive(Debug)]
pub struct PatientStates {
    /// The body at rest.
    pub rest: Body,
    /// Unloading that found it; `None` where the image is at rest.
    pub unloaded: Option<Unloaded>,
    /// The equilibria of the phases; displacements are counted from rest \[length\].
    pub phases: Vec<Solution>,
    /// Displacements from the image, `3 × nodes` \[length\], of the image, the body at rest and the phases.
    pub moved: Vec<Vec<f64>>,
    /// Derivatives of these in each parameter, if asked for: by state, then by parameter.
    pub slopes: Vec<Vec<Vec<f64>>>,
}

/// A θ at which a patient has no states.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum StateError {
    /// θ of another length.
    #[error("theta has {given} entries for {needed} parameters")]
    Length { given: usize, needed: usize },
    /// θ that makes no sense in a state.
    #[error("at {state}: {source}")]
    Theta { state: String, source: ThetaError },
    /// No body at rest.
    #[error(transparent)]
    Unload(#[from] UnloadError),
    /// No equilibrium at a phase.
    #[error("at {phase}: {source}")]
    Phase { phase: String, source: SolveError },
    /// An unstable equilibrium.
    #[error(
        "at {phase}: the equilibrium is unstable, its stiffness has {negative_pivots} negative eigenvalues; the load is beyond what the body \
         bears at this theta"
    )]
    Unstable { phase: String, negative_pivots: usize },
    /// Derivatives that do not exist.
    #[error("at {state}: the places have no derivative in theta: {source}")]
    Slopes { state: String, source: UnloadError },
}

pub(super) type Result<T, E = StateError> = std::result::Result<T, E>;

impl From<StateError> for ForwardError {
    fn from(error: StateError) -> Self {
        Self { reason: error.to_string() }
    }
}

/// A body with the loads of its states.
pub(super) struct Parts<'p> {
    pub image: &'p Body,
    pub unload: Unload<'p>,
    /// The image, where it is at rest.
    pub at_rest: Option<Body>,
    pub parameters: Vec<String>,
    /// Entries of θ of the body in the image, then in the phases, with the names of these states.
    pub loads: Vec<(String, Vec<Entry>)>,
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
        self.loads.iter().try_for_each(|(state, entries)| {
            let checked = self.image.check_theta(&values(entries, theta));
            checked.map_err(|source| StateError::Theta { state: state.clone(), source })
        })
    }

    /// The body at rest and its phases in their order, up to the first without a stable equilibrium, and why that has none.
    pub(super) fn reached(
        &self,
        theta: &[f64],
        anchor: Option<&Anchor<'_>>,
    ) -> Result<(PatientStates, Option<StateError>)> {
        let unload = anchor.map_or(&self.unload, |anchor| &anchor.unload);
        let (rest, phases, end) = Solve::new(self, unload, theta)?.reached(anchor, true)?;
        Ok((PatientStates::of(rest, phases, Vec::new()), end))
    }

    pub(super) fn solve(
        &self,
        theta: &[f64],
        anchor: Option<&Anchor<'_>>,
        derivatives: bool,
    ) -> Result<PatientStates> {
        let unload = anchor.map_or(&self.unload, |anchor| &anchor.unload);
        Solve::new(self, unload, theta)?.states(anchor, derivatives)
    }

    /// States with slopes at the first θ and at those of the others that have them, to predict more from.
    pub(super) fn anchor(&self, thetas: &[Vec<f64>], near: Option<&Anchor>) -> Option<Anchor<'p>> {
        let (first, others) = thetas.split_first()?;
        let mut solve = Solve::new(self, &self.unload, first).ok()?;
        let states = solve.states(near, true).ok()?;
        let mut centre = Anchor::new(vec![Solved::new(first, states)], solve.unload);
        let solve = |theta: &Vec<f64>| {
            self.check(theta).ok()?;
            Some(Solved::new(theta, self.solve(theta, Some(&centre), true).ok()?))
        };
        let more = in_parallel(others, solve);
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
    unload: Unload<'u>,
    theta: &'a [f64],
}

impl<'a, 'u> Solve<'a, 'u> {
    fn new(parts: &'a Parts<'a>, unload: &Unload<'u>, theta: &'a [f64]) -> Result<Self> {
        Ok(Self { parts, unload: unload.fresh().map_err(UnloadError::from)?, theta })
    }

    fn states(&mut self, anchor: Option<&Anchor>, derivatives: bool) -> Result<PatientStates> {
        let (rest, phases, end) = self.reached(anchor, false)?;
        end.map_or(Ok(()), Err)?;
        let slopes = if derivatives { self.slopes(&rest, &phases)? } else { Vec::new() };
        Ok(PatientStates::of(rest, phases, slopes))
    }

    /// The body at rest and its phases, up to the first without a stable equilibrium, and why it has none. Each starts from its prediction by
    /// the anchor, else from the state whose loads are nearest: the nearest phase comes next, or all come in the order in which they were
    /// added.
    fn reached(
        &mut self,
        anchor: Option<&Anchor>,
        in_order: bool,
    ) -> Result<(Rest, Vec<Solution>, Option<StateError>)> {
        let predicted = anchor.map(|anchor| anchor.predict(self.theta));
        let rest = self.rest(predicted.as_deref())?;
        let phases = &self.parts.loads[1..];
        let thetas: Vec<_> = phases.iter().map(|(_, of)| values(of, self.theta)).collect();
        let mut known = self.known(&rest);
        let mut found: Vec<Option<Solution>> = vec![None; thetas.len()];
        let (mut open, mut end): (Vec<usize>, _) = ((0..thetas.len()).collect(), None);
        while !open.is_empty() && end.is_none() {
            let next = if in_order { &open[..1] } else { &open[..] };
            let pairs = next.iter().flat_map(|&phase| known.iter().map(move |from| (phase, from)));
            let pairs = pairs.map(|(phase, (at, u))| (apart(&thetas[phase], at), phase, u));
            let nearest = pairs.min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, phase, near)) = nearest else { break };
            let predicted = predicted.as_ref().map(|all| &all[FIRST_PHASE + phase]);
            let predicted = predicted.map(|moved| difference(moved, &rest.motion));
            let near = predicted.as_ref().unwrap_or(near);
            match self.phase(&rest, &phases[phase].0, near, &thetas[phase]) {
                Ok(solved) => {
                    known.push((thetas[phase].clone(), solved.displacement.clone()));
                    found[phase] = Some(solved);
                    open.retain(|&other| other != phase);
                }
                Err(error) => end = Some(error),
            }
        }
        Ok((rest, found.into_iter().flatten().collect(), end))
    }

    fn rest(&mut self, predicted: Option<&[Vec<f64>]>) -> Result<Rest> {
        let Self { parts, unload, theta } = self;
        if let Some(body) = &parts.at_rest {
            let motion = vec![0.0; 3 * parts.image.nodes];
            return Ok(Rest { body: body.clone(), motion, found: None });
        }
        let values = values(&parts.loads[0].1, theta);
        let near = predicted.and_then(|predicted| {
            let (iterations, accuracy) = (NEAR, parts.accuracy);
            let options = UnloadOptions { iterations, accuracy, load: None };
            unload.solve_near(&predicted[REST], &values, &options).ok()
        });
        let found = near.map_or_else(|| unload.solve(&values, &UnloadOptions::default()), Ok)?;
        let (body, motion) = (found.rest.clone(), found.motion.clone());
        Ok(Rest { body, motion, found: Some(found) })
    }

    /// θ of the body with displacements from rest that are known before any phase: without loads, and in the image.
    fn known(&self, rest: &Rest) -> Vec<(Vec<f64>, Vec<f64>)> {
        let image = values(&self.parts.loads[0].1, self.theta);
        let of_law = self.parts.image.material.parameters().len();
        let mut unloaded = image.clone();
        unloaded[of_law..].fill(0.0);
        let mut known = vec![(unloaded, vec![0.0; rest.motion.len()])];
        if self.parts.at_rest.is_none() {
            known.push((image, rest.motion.iter().map(|w| -w).collect()));
        }
        known
    }

    /// Stable equilibrium of a phase at θ of the body, from a displacement.
    fn phase(&self, rest: &Rest, name: &str, near: &[f64], theta: &[f64]) -> Result<Solution> {
        let options = Options { minimum_accuracy: self.parts.accuracy, ..Options::default() };
        let phase = || name.to_owned();
        let found = self.unload.loaded(&rest.body, near, theta, &options);
        let found = found.map_err(|source| StateError::Phase { phase: phase(), source })?;
        match found.negative_pivots {
            0 => Ok(found),
            negative_pivots => Err(StateError::Unstable { phase: phase(), negative_pivots }),
        }
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
                let directions = directions(&parts.loads[0].1, theta);
                unload.sensitivity_along(found, &directions).map_err(at("rest"))?
            }
        };
        let mut slopes =
            vec![still.clone(), if of_rest.is_empty() { still } else { of_rest.clone() }];
        for ((name, entries), found) in parts.loads[1..].iter().zip(phases) {
            let along = directions(entries, theta);
            let places = unload.loaded_slopes(&rest.body, found, &along, &of_rest);
            slopes.push(places.map_err(at(name))?);
        }
        Ok(slopes)
    }
}

/// θ of the body.
fn values(entries: &[Entry], theta: &[f64]) -> Vec<f64> {
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
