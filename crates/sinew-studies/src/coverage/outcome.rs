//! Answers with their estimates against the solver, and how often an estimate misleads.

use crate::program;
use anyhow::Result;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sinew::Body;
use sinew_emulate::Estimate;
use sinew_energy::metrics::displacement_error;
use sinew_fem::{Options, Solver};
use sinew_num::{difference, norm};

/// True error relative to the displacement up to which an answer is good.
pub(super) const GOOD: f64 = 0.02;

/// Statistics of the answers of one kind for one body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Outcome {
    /// Body and its predictor.
    pub body: String,
    pub predictor: String,
    /// Parameter sets.
    pub cases: usize,
    /// Cases with an equilibrium on the path of a rising load.
    pub solved: usize,
    /// True over estimated error, the larger of energy norm and mean distance, where there are both, in their order.
    pub ratios: Vec<f64>,
    /// Cases with an equilibrium and without an estimate.
    pub refused: usize,
    /// Cases with a true error below a limit, and those of them without an estimate.
    pub good: usize,
    pub good_refused: usize,
    /// Cases without an equilibrium, and those of them with an estimate.
    pub hopeless: usize,
    pub hopeless_estimated: usize,
    /// Estimates that hold for another stable equilibrium than that of a rising load.
    pub elsewhere: usize,
    /// Wall time of an estimate, median \[s\].
    pub estimate_s: f64,
}

/// One answer beside the truth.
pub(super) struct Answer<'a> {
    pub theta: &'a [f64],
    pub displacement: &'a [f64],
    pub estimate: Estimate,
    /// The solution; `None` where there is no equilibrium.
    pub truth: Option<&'a [f64]>,
}

/// Solutions from rest at each of `thetas`, by a rising load where needed.
pub(super) fn solutions(body: &Body, thetas: &[Vec<f64>]) -> Result<Vec<Option<Vec<f64>>>> {
    let solver = Solver::new(body)?;
    let solve = |theta: &Vec<f64>| -> Result<Option<Vec<f64>>> {
        let solved = solver.fresh()?.solve(theta, &Options::default());
        Ok(solved.ok().filter(|found| found.is_stable()).map(|found| found.displacement))
    };
    thetas.par_iter().map(solve).collect()
}

impl Outcome {
    /// Judges all answers of a predictor for a body.
    pub(super) fn of(body: (&str, &Body), predictor: &str, answers: &[Answer<'_>]) -> Result<Self> {
        let (name, body) = body;
        let seconds = answers.iter().map(|answer| answer.estimate.seconds);
        let mut outcome = Self {
            body: name.into(),
            predictor: predictor.into(),
            cases: answers.len(),
            estimate_s: program::median(seconds.collect()).unwrap_or(0.0),
            ..Self::default()
        };
        let mut solver = Solver::new(body)?;
        for answer in answers {
            outcome.judge(&mut solver, answer)?;
        }
        Ok(outcome)
    }

    fn judge(&mut self, solver: &mut Solver<'_>, answer: &Answer<'_>) -> Result<()> {
        let estimated = answer.estimate.distance.is_some();
        let Some(truth) = answer.truth else {
            // A state that solving from the answer ends at is an equilibrium after all.
            match ratio_nearby(solver, answer)? {
                Some(ratio) if ratio <= 2.0 => self.elsewhere += 1,
                _ => {
                    self.hopeless += 1;
                    self.hopeless_estimated += usize::from(estimated);
                }
            }
            return Ok(());
        };
        self.solved += 1;
        let size = norm(truth);
        let good = norm(&difference(answer.displacement, truth)) <= GOOD * size;
        self.good += usize::from(good);
        match ratio(solver, answer, truth)? {
            None => {
                self.refused += 1;
                self.good_refused += usize::from(good);
            }
            Some(found) => {
                // Misled, or right about another equilibrium?
                if found > 2.0 && ratio_nearby(solver, answer)?.is_some_and(|other| other <= 2.0) {
                    self.elsewhere += 1;
                } else {
                    self.ratios.push(found);
                }
            }
        }
        Ok(())
    }

    /// Estimates that are too small by more than a factor.
    pub(super) fn understated(&self, factor: f64) -> usize {
        self.ratios.iter().filter(|ratio| **ratio > factor).count()
    }

    /// Largest ratio of true and estimated error.
    pub(super) fn worst(&self) -> f64 {
        self.ratios.iter().copied().fold(0.0, f64::max)
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.cases += other.cases;
        self.solved += other.solved;
        self.ratios.extend(&other.ratios);
        self.refused += other.refused;
        self.good += other.good;
        self.good_refused += other.good_refused;
        self.hopeless += other.hopeless;
        self.hopeless_estimated += other.hopeless_estimated;
        self.elsewhere += other.elsewhere;
        self.estimate_s = self.estimate_s.max(other.estimate_s);
    }
}

/// True over estimated error, where the truth is the stable equilibrium that solving from the answer ends at.
fn ratio_nearby(solver: &mut Solver<'_>, answer: &Answer<'_>) -> Result<Option<f64>> {
    if answer.estimate.distance.is_none() {
        return Ok(None);
    }
    let found = solver.solve_from(answer.displacement, answer.theta, &Options::default());
    let Some(found) = found.ok().filter(|found| found.is_stable()) else { return Ok(None) };
    ratio(solver, answer, &found.displacement)
}

/// True over estimated error, the larger of energy norm and mean distance, where there is an estimate.
fn ratio(solver: &mut Solver<'_>, answer: &Answer<'_>, truth: &[f64]) -> Result<Option<f64>> {
    /// Rounding errors of a solve \[relative to displacements\].
    const ROUNDING: f64 = 1e-9;
    let Some(distance) = &answer.estimate.distance else { return Ok(None) };
    let off = difference(answer.displacement, truth);
    if norm(&off) <= ROUNDING * norm(truth) {
        return Ok(Some(1.0));
    }
    let nodal = displacement_error(truth, answer.displacement);
    let mean = nodal.iter().sum::<f64>() / nodal.len() as f64;
    let in_energy = solver.energy_norm(truth, answer.theta, &off)?;
    Ok(Some((mean / distance.mean).max(in_energy / distance.energy_norm)))
}
