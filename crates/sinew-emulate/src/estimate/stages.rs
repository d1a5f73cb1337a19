//! Seconds to an accuracy, derived from measured times and errors.

use crate::estimate::evaluate::{TestSet, median};
use crate::estimate::evaluation::{BATCH, Evaluation, Times};
use crate::{Emulator, Result};
use serde::{Deserialize, Serialize};
use sinew_energy::metrics::mean_and_largest;
use std::time::Instant;

/// Quasi-Newton steps of the stage between predictions and Newton steps.
const QUASI_NEWTON: usize = 4;

/// Time per parameter set and error of predictions, as they are or after steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// Steps, in words; empty for predictions as they are.
    pub name: String,
    /// Wall time before the first set \[s\].
    pub once_s: f64,
    /// Wall time of a set on one thread, beyond its prediction \[s\].
    pub each_s: f64,
    /// Mean nodal error relative to the mean nodal displacement, case by case.
    pub errors: Vec<f64>,
}

impl Stage {
    /// Fields on the cases of a test set.
    pub(crate) fn new(
        name: String,
        [once_s, each_s]: [f64; 2],
        test: &TestSet<'_>,
        fields: &[Vec<f64>],
    ) -> Self {
        let error = |(truth, field): (&Vec<f64>, &Vec<f64>)| {
            let apart: Vec<f64> = truth.iter().zip(field).map(|(a, b)| a - b).collect();
            crate::estimate::evaluate::share(
                mean_and_largest(&apart)[0],
                mean_and_largest(truth)[0],
            )
        };
        let errors = test.fields.iter().zip(fields).map(error).collect();
        Self { name, once_s, each_s, errors }
    }

    /// After quasi-Newton steps with the stiffness at the centre of the ranges, factorised once in about the time of a Newton step; `None` if
    /// that stiffness cannot be factorised.
    pub(crate) fn refined(
        emulator: &Emulator<'_>,
        test: &TestSet<'_>,
        step_s: f64,
    ) -> Result<Option<Self>> {
        // The stiffness is factorised with the first.
        if emulator.refine(&test.thetas[..1], QUASI_NEWTON).is_err() {
            return Ok(None);
        }
        let (mut seconds, mut fields) = (Vec::new(), Vec::new());
        for theta in &test.thetas {
            let one = std::slice::from_ref(theta);
            let start = Instant::now();
            fields.push(emulator.refine(one, QUASI_NEWTON)?.displacement);
            seconds.push(start.elapsed().as_secs_f64());
        }
        let name = format!("{QUASI_NEWTON} quasi-Newton steps");
        Ok(Some(Self::new(name, [step_s, median(&seconds)], test, &fields)))
    }
}

impl Evaluation {
    /// Accuracies that reports print times to.
    pub const ACCURACIES: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-6];
    /// Numbers of parameter sets that reports print times for.
    pub const SETS: [usize; 3] = [1, 100, 10_000];

    /// Wall time on one thread until so many parameter sets are within an accuracy, a mean nodal error relative to the mean nodal displacement \[s\].
    ///
    /// It is derived from measurements. Simulations, preparation and training count once. Each set costs a prediction and
    /// the cheapest [`Stage`] whose true error is within the accuracy, averaged over the test cases. A case beyond all
    /// stages costs the most expensive stage and a solve: from a neighbour's solution, or from rest for a single set. Error
    /// checks are not included. They cost about one Newton step more, unless the stage takes one.
    pub fn seconds_to(&self, accuracy: f64, sets: usize) -> f64 {
        let Self { stages, times, .. } = self;
        let cases = stages.first().map_or(0, |stage| stage.errors.len());
        let count = sets as f64;
        let each = |stage: &Stage| stage.each_s + stage.once_s / count;
        let dearest = stages.iter().map(each).fold(0.0, f64::max);
        let of = |case: usize| {
            let within = stages.iter().filter(|stage| stage.errors[case] <= accuracy);
            let least = within.map(each).fold(f64::INFINITY, f64::min);
            if least.is_finite() { least } else { dearest + times.solver_s(sets) / count }
        };
        let steps = (0..cases).map(of).sum::<f64>() / cases as f64;
        let predict = match sets < BATCH {
            true => times.predict_decoder_s,
            false => times.predict_batch_per_theta_s,
        };
        times.simulate_s + times.prepare_s + times.train_s + count * (predict + steps)
    }
}

impl Times {
    /// Wall time of the solver for so many parameter sets on one thread: the first from rest, the others from a neighbour's solution \[s\]. Its
    /// solutions are within rounding errors, whatever accuracy is asked for.
    pub fn solver_s(&self, sets: usize) -> f64 {
        match sets {
            0 => 0.0,
            _ => self.solver_cold_s + (sets - 1) as f64 * self.solver_warm_s,
        }
    }
}
