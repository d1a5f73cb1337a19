//! Provenance of an emulator.

use crate::Warning;
use crate::estimate::evaluate::{CaseErrors, Errors, root_mean_square};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Provenance of an emulator: recipe, simulations, times, errors and warnings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Short name of its recipe.
    pub recipe: String,
    /// Description, in one line.
    pub about: String,
    /// Simulations that it learned from.
    pub simulations: usize,
    /// Wall time of them \[s\].
    pub simulate_s: f64,
    /// Wall time of graph and coordinates \[s\].
    pub prepare_s: f64,
    /// Wall time of training \[s\].
    pub train_s: f64,
    /// Optimiser steps of all stages.
    pub steps: u64,
    /// Errors on the held-out cases on the way; empty for a regression.
    pub history: Vec<CurvePoint>,
    /// Virtual nodes of each level of its network's graph; empty where there are none.
    #[serde(default)]
    pub virtual_nodes: Vec<usize>,
    /// Weights of the networks that were kept, where some were trained.
    pub kept: Option<Kept>,
    /// Candidates and the reason for the one taken, where there was a choice.
    pub choice: Option<Choice>,
    /// Calibration of the error estimate on the held-out cases.
    pub calibration: Calibration,
    /// Errors on the held-out cases.
    pub held_out: Option<Errors>,
    /// Reasons not to trust it; none after a training that went well.
    pub warnings: Vec<Warning>,
}

impl Record {
    /// The candidate that was taken, where there was a choice.
    pub fn taken(&self) -> Option<&Candidate> {
        self.choice.as_ref().and_then(|choice| choice.candidates.get(choice.taken))
    }

    /// Empty record of a recipe, by its short name.
    pub fn new(recipe: &str) -> Self {
        Self { recipe: recipe.into(), ..Self::default() }
    }
}

/// An evaluation on the held-out cases during training.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Steps made, of all stages.
    pub step: u64,
    /// Seconds of training.
    pub train_s: f64,
    /// Mean training loss since the evaluation before.
    pub loss: f64,
    /// Medians over the held-out cases, as in [`Errors`]: `err_u` \[length\], `err_F`, `err_I1` and `err_Π`
    /// [%]. `None` where one is not finite.
    pub medians: Option<[f64; 4]>,
    /// Mean energy above the minimum [%]; `None` where it is not finite.
    pub energy_excess_pct: Option<f64>,
    /// Root mean square of `‖u − û‖ / ‖u‖` over the held-out cases, times one plus the share of inverted predictions. The
    /// weights with the lowest value are kept. `None` where it is not finite.
    pub error: Option<f64>,
    /// Held-out predictions that invert a cell.
    pub inverted: usize,
}

/// The weights that a training kept.
#[doc(alias = "early stopping")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// Steps after which they were found, of all stages.
    pub step: u64,
    /// Their [`CurvePoint::error`]; `None` where none was finite, so that the last weights were kept.
    pub error: Option<f64>,
    /// Number of returns to the best weights, each with half the learning rate, over all stages.
    pub returns: usize,
}

impl CurvePoint {
    /// Notes errors of the held-out cases; [`CurvePoint::error`], finite or not.
    pub fn measure(&mut self, cases: &[CaseErrors]) -> f64 {
        let errors = Errors::of(cases);
        let medians = [errors.err_u, errors.err_f, errors.err_i1, errors.err_pi].map(|q| q.q50);
        let excess = cases.iter().map(|case| 100.0 * case.energy_excess).sum::<f64>();
        let (excess, error) = (excess / cases.len() as f64, root_mean_square(cases));
        self.medians = medians.iter().all(|&m| m < f64::MAX).then_some(medians);
        self.energy_excess_pct = excess.is_finite().then_some(excess);
        self.error = error.is_finite().then_some(error);
        self.inverted = cases.iter().filter(|case| case.inverted).count();
        error
    }
}

/// A regression that was tried, and how well it did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Simulations that it learned from.
    pub simulations: usize,
    /// Root mean square of `‖u − û‖ / ‖u‖` over the held-out cases, times one plus the share of inverted predictions, for
    /// every candidate.
    pub error: f64,
    /// Wall time of simulations and training \[s\].
    pub seconds: f64,
    /// Details of the candidate, in words.
    pub detail: String,
}

/// Candidates and the one taken; printed, it says why.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// Candidates in the order they were tried.
    pub candidates: Vec<Candidate>,
    /// Index of the one that was taken.
    pub taken: usize,
    /// Error that settles the choice for a regression.
    pub target: f64,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Candidate { simulations, error, seconds, detail } in &self.candidates {
            writeln!(
                f,
                "regression on {simulations} simulations: root mean square error {error:.1e} after {seconds:.1} s ({detail})"
            )?;
        }
        let Some(taken) = self.candidates.get(self.taken) else { return Ok(()) };
        let (count, error, target) = (taken.simulations, taken.error, self.target);
        let why = match error <= target {
            true => format!("its error {error:.1e} meets the target of {target:.1e}"),
            false => format!(
                "none met the target of {target:.1e}, and its error {error:.1e} is the least"
            ),
        };
        write!(f, "that on {count} was taken: {why}")
    }
}

/// True errors beside their estimates, over held-out cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Held-out cases.
    pub cases: usize,
    /// Cases without an estimate: not near an equilibrium, by its own checks.
    pub refused: usize,
    /// Cases of these whose prediction inverts a cell.
    pub inverted: usize,
    /// Share of the estimated cases whose true error is within a factor of two of the estimate, both in the energy norm and in the
    /// mean distance.
    pub within_two: f64,
}

/// Estimates are to be within a factor of two this often.
const EXPECTED: f64 = 0.95;

impl Calibration {
    /// Warnings about estimates that are absent, or hold less often than they should.
    pub(crate) fn warnings(&self) -> Vec<Warning> {
        let Self { cases, refused, inverted, within_two } = *self;
        let of = format!("for {inverted} of {cases} held-out cases");
        let poor = Warning::PoorEstimates { share: within_two, cases: cases - refused };
        let warnings = [
            (inverted > 0, Warning::Inverted { of }),
            (refused > inverted, Warning::RefusedEstimates { refused, cases }),
            (refused < cases && within_two < EXPECTED, poor),
        ];
        warnings.into_iter().filter_map(|(holds, warning)| holds.then_some(warning)).collect()
    }
}
