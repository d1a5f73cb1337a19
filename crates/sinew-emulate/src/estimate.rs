//! Error estimates of predictions: the distance to the nearby equilibrium, or the reason for none.

pub(crate) mod evaluate;
pub(crate) mod evaluation;

use crate::estimate::evaluate::share;
use crate::{Emulator, Error, Prediction, Result, Warning};
use serde::{Deserialize, Serialize};
use sinew_fem::ErrorEstimate;
use sinew_num::try_in_parallel;

/// Error estimate of a displacement, by Newton steps from it that contract ([`sinew_fem::Solver::error_estimate`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Distance to the equilibrium nearby; `None` without an equilibrium, for the reason among the warnings.
    pub distance: Option<Distance>,
    /// Norm of the unbalanced nodal forces \[relative to loads and reactions at this displacement\]; `None` where it inverts a cell.
    pub residual: Option<f64>,
    /// Newton steps behind it, each with a factorisation.
    pub newton_steps: usize,
    /// Wall-clock time \[s\].
    pub seconds: f64,
    /// Reasons not to trust displacement or estimate.
    pub warnings: Vec<Warning>,
}

/// Distance of a displacement from the equilibrium nearby.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distance {
    /// Mean nodal distance \[length\].
    pub mean: f64,
    /// Largest nodal distance \[length\].
    pub largest: f64,
    /// Energy norm of the error `‖u − û‖_K` [√(stress·length³)].
    pub energy_norm: f64,
    /// Energy norm relative to `√(2 |Π|)`.
    pub relative: f64,
    /// Contraction ratio: length of the simplified Newton step relative to the Newton step before it.
    pub contraction: f64,
}

impl From<ErrorEstimate> for Estimate {
    fn from(found: ErrorEstimate) -> Self {
        let ErrorEstimate { residual, energy, newton_steps, seconds, distance, .. } = found;
        let reason = distance.as_ref().err().map(ToString::to_string);
        let warnings = reason.map(|reason| Warning::NotNearEquilibrium { reason });
        let distance = distance.ok().map(|found| Distance {
            mean: found.mean,
            largest: found.largest,
            energy_norm: found.energy_norm,
            relative: share(found.energy_norm, (2.0 * energy.abs()).sqrt()),
            contraction: found.contraction,
        });
        let residual = residual.is_finite().then_some(residual);
        Self { distance, residual, newton_steps, seconds, warnings: warnings.into_iter().collect() }
    }
}

impl Estimate {
    /// Text with the unit of lengths: `error 0.012 mm in the mean, 0.05 mm at most`, or why there is no estimate.
    pub fn in_words(&self, unit: &str) -> String {
        let Some(Distance { mean, largest, relative, .. }) = self.distance else {
            let reason = |warning: &Warning| match warning {
                Warning::NotNearEquilibrium { reason } => Some(reason.clone()),
                _ => None,
            };
            let reason = self.warnings.iter().find_map(reason).unwrap_or_default();
            return format!("no error estimate: {reason}");
        };
        let percent = 100.0 * relative;
        format!(
            "estimated error {mean:.1e} {unit} in the mean, {largest:.1e} {unit} at most, {percent:.2} % in the energy norm"
        )
    }
}

impl Emulator<'_> {
    /// Error estimate of one case of a prediction.
    ///
    /// # Errors
    /// A case that there is not. A prediction that inverts a cell or is not near an equilibrium is no error: it has no
    /// [`Estimate::distance`], and its warnings say why.
    pub fn estimate(&self, prediction: &Prediction, case: usize) -> Result<Estimate> {
        let cases = prediction.thetas.len();
        let none = || Error::Request(format!("there is no case {case} in a prediction of {cases}"));
        let theta = prediction.thetas.get(case).ok_or_else(none)?;
        let mut estimate = self.estimate_of(prediction.field(case), theta)?;
        estimate.warnings.extend(prediction.warnings[case].iter().cloned());
        Ok(estimate)
    }

    /// Error estimates of all cases of a prediction, on all cores.
    ///
    /// # Errors
    /// A body that cannot be solved at all.
    pub fn estimates(&self, prediction: &Prediction) -> Result<Vec<Estimate>> {
        try_in_parallel(0..prediction.thetas.len(), |case| self.estimate(prediction, case))
    }

    /// Error estimate of a displacement at θ, found by any method.
    pub(crate) fn estimate_of(&self, displacement: &[f64], theta: &[f64]) -> Result<Estimate> {
        Ok(self.solvers.with(|solver| solver.error_estimate(displacement, theta))?.into())
    }
}
