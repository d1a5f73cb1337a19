//! Corrections of a prediction: steps of Newton's method, or quasi-Newton steps with one stiffness for all.

use crate::parameters::{check_length, extrapolation};
use crate::{Emulator, Estimate, Prediction, Result, Warning, taylor};
use rayon::prelude::*;
use sinew_energy::metrics::displacement_error;
use sinew_fem::{Descent, FrozenTangent, NewtonStep, SolveError, Solver};
use std::sync::Arc;
use std::time::Instant;

/// Mean nodal length of the first step relative to the displacement from where on a correction may hurt: below 2 %
/// every step helps, measured on the thesis' scenes.
const FAR: f64 = 0.04;

/// Unbalanced forces \[relative to loads and reactions\] from which on refined predictions are said to be out of balance: errors of
/// displacements are of this order or larger then.
const UNBALANCED: f64 = 1e-2;

/// A prediction after some Newton steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    /// Corrected displacement, node by node \[length\].
    pub displacement: Vec<f64>,
    /// The steps, each with its residuals and time.
    pub steps: Vec<NewtonStep>,
    /// Error estimate of the corrected displacement.
    pub estimate: Estimate,
    /// Wall-clock time of the prediction that was corrected \[s\].
    pub predict_s: f64,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

impl<'b> Emulator<'b> {
    /// The prediction for `theta` after at most `steps` Newton steps.
    ///
    /// A step is shortened until it turns no cell over and lowers the energy. Steps that were shortened, that left the
    /// forces less balanced or that began too far away are in the warnings, and so is an end that is not near an equilibrium.
    ///
    /// # Errors
    /// As [`Emulator::predict`], and a prediction that inverts a cell.
    pub fn correct(&self, theta: &[f64], steps: usize) -> Result<Correction> {
        check_length(self.body, theta)?;
        let start = Instant::now();
        let predicted = self.predict(&[theta.to_vec()])?.displacement;
        let predict_s = start.elapsed().as_secs_f64();
        let steps =
            self.with_solver(|solver| Ok(solver.newton_steps(&predicted, theta, steps)?))?;
        let mut warnings = extrapolation(self.body, theta);
        warnings.extend(misgivings(&predicted, &steps));
        let displacement = steps.last().map_or(predicted, |step| step.displacement.clone());
        let estimate = self.estimate_of(&displacement, theta)?;
        warnings.extend(estimate.warnings.iter().cloned());
        Ok(Correction { displacement, steps, estimate, predict_s, warnings })
    }

    /// The predictions for `thetas` after at most `steps` quasi-Newton steps towards lower energy each, all with the stiffness that the body
    /// has at the centre of the parameters' ranges: between a prediction and Newton steps in error and in time, a gradient and a
    /// back-substitution a step. A prediction that turns cells over begins at the state of that stiffness instead. Without steps the
    /// predictions themselves. Cases whose forces are far from balanced where the steps end say so in their warnings.
    ///
    /// # Errors
    /// As [`Emulator::predict`], and a body without stiffness at that centre.
    pub fn refine(&self, thetas: &[Vec<f64>], steps: usize) -> Result<Prediction> {
        if steps == 0 {
            return self.predict(thetas);
        }
        let held = self.held()?;
        let mut prediction = self.predict(thetas)?;
        let refine = |(case, theta): (usize, &Vec<f64>)| -> Result<Descent> {
            let found = match held.descend(prediction.field(case), theta, steps) {
                Err(SolveError::Inadmissible { .. }) => {
                    held.descend(&held.displacement, theta, steps)
                }
                found => found,
            };
            Ok(found?)
        };
        let refined: Vec<Descent> =
            thetas.par_iter().enumerate().map(refine).collect::<Result<_>>()?;
        for (descent, warnings) in refined.iter().zip(&mut prediction.warnings) {
            let residual = descent.unbalanced();
            warnings.extend((residual > UNBALANCED).then_some(Warning::Unbalanced { residual }));
        }
        prediction.displacement = refined.into_iter().flat_map(|d| d.displacement).collect();
        Ok(prediction)
    }

    /// The stiffness at the centre, factorised once; by several threads at once where they need it at once.
    fn held(&self) -> Result<Arc<FrozenTangent<'b>>> {
        let kept = || self.held.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some(held) = &*kept() {
            return Ok(held.clone());
        }
        let centre = self.body.centre();
        let state = self.predict(std::slice::from_ref(&centre))?.displacement;
        let state = taylor::admissible(self.body, &state);
        let held = self.with_solver(|solver| Ok(solver.frozen_tangent(&state, &centre)?))?;
        Ok(kept().get_or_insert_with(|| Arc::new(held)).clone())
    }

    /// Calls with a solver of the body, of which one is prepared for every thread that calls.
    pub(crate) fn with_solver<T>(
        &self,
        call: impl FnOnce(&mut Solver<'b>) -> Result<T>,
    ) -> Result<T> {
        // Nothing is locked while it works: each thread that works at the same time has a solver of its own.
        let idle = || self.solvers.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let taken = idle().pop();
        let mut solver = match taken {
            Some(solver) => solver,
            None => Solver::new(self.body)?,
        };
        let called = call(&mut solver);
        idle().push(solver);
        called
    }
}

/// Warnings about Newton steps from a prediction.
fn misgivings(predicted: &[f64], steps: &[NewtonStep]) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if let Some(first) = steps.first() {
        let moved = mean(&displacement_error(predicted, &first.displacement));
        let size = mean(&displacement_error(&first.displacement, &vec![0.0; predicted.len()]));
        let relative = moved / size;
        if relative > FAR {
            warnings.push(Warning::FarForCorrection { relative, limit: FAR });
        }
    }
    for (index, step) in steps.iter().enumerate() {
        if step.residual_rose() {
            let (before, after) = (step.residual_before, step.residual_after);
            warnings.push(Warning::ResidualRose { step: index + 1, before, after });
        }
        if step.length < 1.0 {
            warnings.push(Warning::ShortStep { step: index + 1, length: step.length });
        }
    }
    warnings
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
