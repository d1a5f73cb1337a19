//! Corrections of a prediction: steps of Newton's method, or quasi-Newton steps with a frozen stiffness for all.

use crate::parameters::{check_length, extrapolation};
use crate::predict::taylor;
use crate::{Emulator, Estimate, Prediction, Result, Warning};
use rayon::prelude::*;
use sinew_energy::metrics::mean_and_largest;
use sinew_fem::{FrozenStiffness, NewtonStep, Refined, SolveError, Stop};

/// Mean nodal length of the first Newton step \[relative to the displacement\]. Above it, a correction may raise the error.
/// Below 2 %, every step lowered the error on the thesis' scenes.
const FAR: f64 = 0.04;

/// Residual \[relative to loads and reactions\] above which a refined prediction gets a warning. The displacement error is
/// then of this order or larger.
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
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

impl<'b> Emulator<'b> {
    /// The prediction for `theta` after at most `steps` Newton steps.
    ///
    /// A step is shortened until it inverts no cell and lowers the energy. Warnings name shortened steps, steps that raised
    /// the residual, a start too far from equilibrium, and an end that is not near one.
    ///
    /// # Errors
    /// As [`Emulator::predict`], and a prediction that inverts a cell.
    pub fn correct(&self, theta: &[f64], steps: usize) -> Result<Correction> {
        check_length(self.body, theta)?;
        let predicted = self.predict(&[theta.to_vec()])?.displacement;
        let steps = self.solvers.with(|solver| solver.newton_steps(&predicted, theta, steps))?;
        let mut warnings = extrapolation(self.body, theta);
        warnings.extend(misgivings(&predicted, &steps));
        let displacement = steps.last().map_or(predicted, |step| step.displacement.clone());
        let estimate = self.estimate_of(&displacement, theta)?;
        warnings.extend(estimate.warnings.iter().cloned());
        Ok(Correction { displacement, steps, estimate, warnings })
    }

    /// The predictions for `thetas` after at most `steps` quasi-Newton steps, which lower the energy. All steps use the
    /// stiffness at the centre of the parameters' ranges, so that a step costs a gradient and a back-substitution. Error
    /// and time lie between those of the prediction and of Newton steps. If a prediction inverts cells, the steps start
    /// from the state of that stiffness ([`FrozenStiffness::descend`]). With `steps = 0` the predictions are returned. A case with a large residual at the
    /// end carries a warning.
    ///
    /// # Errors
    /// As [`Emulator::predict`], and a body without stiffness at that centre.
    pub fn refine(&self, thetas: &[Vec<f64>], steps: usize) -> Result<Prediction> {
        if steps == 0 {
            return self.predict(thetas);
        }
        let held = self.held()?;
        let mut prediction = self.predict(thetas)?;
        let refine = |(case, theta): (usize, &Vec<f64>)| {
            let predicted = prediction.field(case);
            match held.refine(self.body, predicted, theta, Stop::after(steps)) {
                Err(SolveError::Inadmissible { .. }) => held.descend(self.body, theta, steps),
                found => found,
            }
        };
        let refined = thetas.par_iter().enumerate().map(refine);
        let refined: Vec<Refined> = refined.collect::<std::result::Result<_, _>>()?;
        for (refined, warnings) in refined.iter().zip(&mut prediction.warnings) {
            let residual = refined.unbalanced();
            warnings.extend((residual > UNBALANCED).then_some(Warning::Unbalanced { residual }));
        }
        prediction.displacement = refined.into_iter().flat_map(|d| d.displacement).collect();
        Ok(prediction)
    }

    /// Stiffness at the centre, factorised once. Threads that need it at the same time may each factorise it.
    fn held(&self) -> Result<&FrozenStiffness<'b>> {
        if let Some(held) = self.held.get() {
            return Ok(held);
        }
        let centre = self.body.centre();
        let state = self.predict(std::slice::from_ref(&centre))?.displacement;
        let state = taylor::admissible(self.body, &state);
        let held = self.solvers.with(|solver| solver.frozen_stiffness(&state, &centre))?;
        Ok(self.held.get_or_init(|| held))
    }
}

/// Warnings about Newton steps from a prediction.
fn misgivings(predicted: &[f64], steps: &[NewtonStep]) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if let Some(first) = steps.first() {
        let apart: Vec<_> = predicted.iter().zip(&first.displacement).map(|(a, b)| a - b).collect();
        let relative = mean_and_largest(&apart)[0] / mean_and_largest(&first.displacement)[0];
        if relative > FAR {
            warnings.push(Warning::FarForCorrection { relative, limit: FAR });
        }
    }
    for (index, step) in steps.iter().enumerate() {
        let (before, after) = (step.residual_before, step.residual_after);
        if after > before {
            warnings.push(Warning::ResidualRose { step: index + 1, before, after });
        }
        if step.length < 1.0 {
            warnings.push(Warning::ShortStep { step: index + 1, length: step.length });
        }
    }
    warnings
}
