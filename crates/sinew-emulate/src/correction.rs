//! How far a prediction is from the truth, and how to come nearer: steps of Newton's method, or with one stiffness for all.

use crate::evaluate::share;
use crate::parameters::{check_length, extrapolation};
use crate::{Emulator, Error, Prediction, Result, Warning, coordinates};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sinew_energy::metrics::displacement_error;
use sinew_fem::{HeldStiffness, NewtonStep, SolveError, Solver};
use std::sync::Arc;
use std::time::Instant;

/// Mean nodal length of the first step relative to the displacement from where on a correction may hurt: below 2 %
/// every step helps, measured on the thesis' scenes.
const FAR: f64 = 0.04;

/// How far a prediction is from equilibrium.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Energy norm of the error `‖u − û‖_K` [√(stress·length³)]: that of a Newton step times the factor of the
    /// calibration.
    pub energy_norm: f64,
    /// The true one lies between these in 95 % of the held-out cases.
    pub between: [f64; 2],
    /// The estimate relative to the energy norm that the potential energy amounts to, `√(2 |Π|)`.
    pub relative: f64,
    /// Mean nodal length of the Newton step \[length\]: an estimate of the mean nodal error.
    pub mean_distance: f64,
    /// Norm of the unbalanced nodal forces \[stress·length²\].
    pub residual: f64,
    /// Norm of loads and reactions \[stress·length²\], to compare the residual with.
    pub force_scale: f64,
    /// Wall-clock time \[s\].
    pub seconds: f64,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

/// A prediction after some Newton steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    /// Corrected displacement, node by node \[length\].
    pub displacement: Vec<f64>,
    /// The steps, each with its residuals and time.
    pub steps: Vec<NewtonStep>,
    /// Wall-clock time of the prediction that was corrected \[s\].
    pub predict_s: f64,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

impl<'b> Emulator<'b> {
    /// How far one case of a prediction is from equilibrium, by one Newton step.
    ///
    /// # Errors
    /// A case that there is not, or one that inverts a cell.
    pub fn estimate(&self, prediction: &Prediction, case: usize) -> Result<Estimate> {
        let cases = prediction.thetas.len();
        let theta = prediction.thetas.get(case).ok_or(Error::NoSuchCase { case, cases })?;
        let field = prediction.field(case);
        let step = self.with_solver(|solver| Ok(solver.newton_step(field, theta)?))?;
        let calibration = &self.record.calibration;
        let energy_norm = calibration.factor * step.energy_norm;
        let moved = displacement_error(field, &step.displacement);
        let whole = if step.length > 0.0 { step.length } else { 1.0 };
        let mut warnings = prediction.outside[case].clone();
        warnings.extend((step.shift > 0.0).then_some(Warning::Indefinite));
        Ok(Estimate {
            energy_norm,
            between: [energy_norm / calibration.spread, energy_norm * calibration.spread],
            relative: share(energy_norm, (2.0 * step.energy_after.abs()).sqrt()),
            mean_distance: mean(&moved) / whole,
            residual: step.residual_before,
            force_scale: step.force_scale,
            seconds: step.seconds,
            warnings,
        })
    }

    /// The prediction for `theta` after at most `steps` Newton steps.
    ///
    /// A step is shortened until it turns no cell over and lowers the energy. Steps that were shortened, that left the
    /// forces less balanced or that began too far away are in the warnings.
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
        Ok(Correction { displacement, steps, predict_s, warnings })
    }

    /// The predictions for `thetas` after at most `steps` quasi-Newton steps towards lower energy each, all with the stiffness that the body
    /// has at the centre of the parameters' ranges: between a prediction and Newton steps in error and in time, a gradient and a
    /// back-substitution a step. A prediction that turns cells over begins at the state of that stiffness instead. Without steps the
    /// predictions themselves.
    ///
    /// # Errors
    /// As [`Emulator::predict`], and a body without stiffness at that centre.
    pub fn refine(&self, thetas: &[Vec<f64>], steps: usize) -> Result<Prediction> {
        if steps == 0 {
            return self.predict(thetas);
        }
        let held = self.held()?;
        let mut prediction = self.predict(thetas)?;
        let refine = |(case, theta): (usize, &Vec<f64>)| -> Result<Vec<f64>> {
            let found = match held.descend(prediction.field(case), theta, steps) {
                Err(SolveError::Inadmissible { .. }) => {
                    held.descend(&held.displacement, theta, steps)
                }
                found => found,
            };
            Ok(found?.displacement)
        };
        let refined: Result<Vec<_>> = thetas.par_iter().enumerate().map(refine).collect();
        prediction.displacement = refined?.concat();
        Ok(prediction)
    }

    /// The stiffness at the centre, factorised once; by several threads at once where they need it at once.
    fn held(&self) -> Result<Arc<HeldStiffness<'b>>> {
        let kept = || self.held.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some(held) = &*kept() {
            return Ok(held.clone());
        }
        let centre = self.body.centre();
        let state = self.predict(std::slice::from_ref(&centre))?.displacement;
        let state = coordinates::admissible(self.body, &state);
        let held = self.with_solver(|solver| Ok(solver.held_stiffness(&state, &centre)?))?;
        Ok(kept().get_or_insert_with(|| Arc::new(held)).clone())
    }

    /// Calls with the solver of the body, which is prepared once.
    pub(crate) fn with_solver<T>(
        &self,
        call: impl FnOnce(&mut Solver<'b>) -> Result<T>,
    ) -> Result<T> {
        // Nothing is locked while it works: what works may wait for others that need one too.
        let kept = || self.solver.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let taken = kept().take();
        let mut solver = match taken {
            Some(solver) => solver,
            None => Solver::new(self.body)?,
        };
        let called = call(&mut solver);
        *kept() = Some(solver);
        called
    }
}

/// What to say about steps from a prediction.
fn misgivings(predicted: &[f64], steps: &[NewtonStep]) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if let Some(first) = steps.first() {
        let moved = mean(&displacement_error(predicted, &first.displacement));
        let size = mean(&displacement_error(&first.displacement, &vec![0.0; predicted.len()]));
        let relative = moved / size;
        if relative > FAR {
            warnings.push(Warning::FarForCorrection { relative, limit: FAR });
        }
        warnings.extend((first.shift > 0.0).then_some(Warning::Indefinite));
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
