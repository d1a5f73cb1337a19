//! How well the error estimate does, measured on held-out cases.

use crate::coordinates::dot;
use crate::evaluate::{Errors, TestSet};
use crate::{Emulator, Error, Result, Warning};
use serde::{Deserialize, Serialize};
use sinew_fem::{NewtonStep, SolveError};

/// True energy-norm error over the one that a Newton step foresees, over held-out cases.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Held-out cases.
    pub cases: usize,
    /// Cases whose prediction inverts a cell, so that no step can be made.
    pub inverted: usize,
    /// Median of the ratios: estimates are multiplied by it.
    pub factor: f64,
    /// Within this factor of the estimate lie 95 % of the true errors.
    pub spread: f64,
    /// Share of the cases whose calibrated estimate is within a factor of two.
    pub within_two: f64,
}

impl Default for Calibration {
    fn default() -> Self {
        Self { cases: 0, inverted: 0, factor: 1.0, spread: f64::MAX, within_two: 0.0 }
    }
}

/// Estimates are to be within a factor of two this often.
const EXPECTED: f64 = 0.95;

impl Calibration {
    /// From the emulator's predictions for held-out cases, whose errors are returned with it.
    pub(crate) fn on(emulator: &Emulator<'_>, held_out: &TestSet<'_>) -> Result<(Self, Errors)> {
        let fields = emulator.predict(&held_out.thetas)?.fields();
        let errors = held_out.errors(&fields)?;
        let mut ratios = Vec::with_capacity(fields.len());
        for (case, field) in fields.iter().enumerate() {
            let theta = &held_out.thetas[case];
            match emulator.with_solver(|solver| Ok(solver.newton_step(field, theta)?)) {
                Ok(step) => ratios.push(ratio(emulator, held_out, case, field, &step)?),
                Err(Error::Solve(SolveError::Inadmissible { .. })) => {}
                Err(other) => return Err(other),
            }
        }
        Ok((Self::of(&mut ratios, fields.len()), errors))
    }

    /// From ratios of true to foreseen errors in `cases` cases.
    fn of(ratios: &mut [f64], cases: usize) -> Self {
        let inverted = cases - ratios.len();
        ratios.sort_by(f64::total_cmp);
        let Some(&factor) = ratios.get(ratios.len() / 2) else {
            return Self { cases, inverted, ..Self::default() };
        };
        let mut departures: Vec<f64> = ratios.iter().map(|r| (r / factor).ln().abs()).collect();
        departures.sort_by(f64::total_cmp);
        let rank = (EXPECTED * departures.len() as f64).ceil() as usize;
        let spread = departures[rank.clamp(1, departures.len()) - 1].exp();
        let within = departures.iter().filter(|&&d| d <= 2f64.ln()).count();
        Self { cases, inverted, factor, spread, within_two: within as f64 / cases as f64 }
    }

    /// What to say about estimates that hold less often than they should.
    pub(crate) fn warnings(&self) -> Vec<Warning> {
        let inverted = (self.inverted > 0).then(|| Warning::Inverted {
            of: format!("for {} of {} held-out cases", self.inverted, self.cases),
        });
        let poor = (self.within_two < EXPECTED)
            .then_some(Warning::PoorEstimates { share: self.within_two, cases: self.cases });
        inverted.into_iter().chain(poor).collect()
    }
}

/// True energy-norm error of a case over the one that a Newton step from it foresees.
pub(crate) fn ratio(
    emulator: &Emulator<'_>,
    held_out: &TestSet<'_>,
    case: usize,
    field: &[f64],
    step: &NewtonStep,
) -> Result<f64> {
    let (theta, truth) = (&held_out.thetas[case], &held_out.fields[case]);
    let difference: Vec<f64> = field.iter().zip(truth).map(|(a, b)| a - b).collect();
    // A prediction that is exact to rounding has nothing to compare.
    let rounding = f64::EPSILON * dot(truth, truth).sqrt();
    let exact = dot(&difference, &difference).sqrt() <= 100.0 * rounding;
    if exact || step.energy_norm == 0.0 {
        return Ok(1.0);
    }
    let actual =
        emulator.with_solver(|solver| Ok(solver.energy_norm(truth, theta, &difference)?))?;
    Ok(actual / step.energy_norm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factor_and_spread_of_known_ratios() {
        let mut ratios: Vec<f64> = (0..19).map(|_| 1.1).chain([4.4]).collect();
        let found = Calibration::of(&mut ratios, 20);
        assert_eq!((found.factor, found.within_two, found.inverted), (1.1, 0.95, 0));
        assert!((found.spread - 1.0).abs() < 1e-12 && found.warnings().is_empty());
        let found = Calibration::of(&mut ratios[..10].to_vec(), 20);
        assert_eq!((found.inverted, found.within_two), (10, 0.5));
        assert_eq!(found.warnings().len(), 2);
        let none = Calibration::of(&mut [], 3);
        assert_eq!((none.factor, none.within_two), (1.0, 0.0));
    }
}
