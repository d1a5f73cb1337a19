//! Quality of the error estimate on held-out cases.

use crate::estimate::evaluate::{Errors, TestSet, share};
use crate::store::record::Calibration;
use crate::{Distance, Emulator, Result};
use rayon::prelude::*;
use sinew_energy::metrics::mean_and_largest;
use sinew_num::dot;

impl Calibration {
    /// Calibration on the emulator's predictions for held-out cases, whose errors are returned with it.
    pub(crate) fn on(emulator: &Emulator<'_>, held_out: &TestSet<'_>) -> Result<(Self, Errors)> {
        let fields = emulator.predict(&held_out.thetas)?.fields();
        let errors = held_out.errors(&fields)?;
        Ok((Self::of(&ratios(emulator, held_out, &fields)?), errors))
    }

    pub(crate) fn of(judged: &[Judged]) -> Self {
        let is_within_two =
            |ratios: &&[f64; 2]| ratios.iter().all(|ratio| (0.5..=2.0).contains(ratio));
        let estimated = judged.iter().flatten().count();
        let within = judged.iter().flatten().filter(is_within_two).count();
        Self {
            cases: judged.len(),
            refused: judged.len() - estimated,
            inverted: judged.iter().filter(|judged| **judged == Err(true)).count(),
            within_two: within as f64 / estimated.max(1) as f64,
        }
    }
}

/// True error over its estimate, in the energy norm and in the mean nodal distance; without an estimate, whether the prediction inverts a
/// cell.
pub(crate) type Judged = std::result::Result<[f64; 2], bool>;

/// True errors over their estimates, case by case.
pub(crate) fn ratios(
    emulator: &Emulator<'_>,
    test: &TestSet<'_>,
    fields: &[Vec<f64>],
) -> Result<Vec<Judged>> {
    let judge = |(case, field): (usize, &Vec<f64>)| -> Result<Judged> {
        let estimate = emulator.estimate_of(field, &test.thetas[case])?;
        match estimate.distance {
            Some(distance) => Ok(Ok(ratio(emulator, test, case, field, &distance)?)),
            None => Ok(Err(estimate.residual.is_none())),
        }
    };
    fields.par_iter().enumerate().map(judge).collect()
}

fn ratio(
    emulator: &Emulator<'_>,
    test: &TestSet<'_>,
    case: usize,
    field: &[f64],
    distance: &Distance,
) -> Result<[f64; 2]> {
    /// Rounding errors of a solve \[relative to displacements\]: a prediction that is as exact has no error to compare.
    const ROUNDING: f64 = 1e-12;
    let (theta, truth) = (&test.thetas[case], &test.fields[case]);
    let difference: Vec<f64> = field.iter().zip(truth).map(|(a, b)| a - b).collect();
    if dot(&difference, &difference).sqrt() <= ROUNDING * dot(truth, truth).sqrt() {
        return Ok([1.0; 2]);
    }
    let in_energy =
        emulator.solvers.with(|solver| solver.energy_norm(truth, theta, &difference))?;
    let [mean, _] = mean_and_largest(&difference);
    Ok([share(in_energy, distance.energy_norm), share(mean, distance.mean)])
}
