//! An emulator against a test set: errors raw and corrected, estimates, times.

use crate::estimate::evaluate::{Errors, TestSet, median, median_seconds, misfits, share};
use crate::parameters::check_length;
use crate::{Calibration, Emulator, Result};
use serde::{Deserialize, Serialize};
use sinew_energy::metrics::mean_and_largest;
use sinew_fem::{NewtonStep, Options, SolveError, Solver};
use sinew_num::{difference, norm, try_in_parallel};
use std::time::Instant;

/// Repetitions behind every prediction time.
const REPEATS: usize = 15;
/// Parameter sets in a batch whose time per set is measured.
pub(crate) const BATCH: usize = 200;
/// Cold solves behind the solver's time.
const COLD_SOLVES: usize = 5;

/// Least denominator of a sensitivity error: this share of the displacement over the parameter's range.
const LEAST_MOTION: f64 = 1e-3;
/// Cases behind a median.
const CASES: usize = 10;

/// Quasi-Newton steps of the stage between predictions and Newton steps.
const QUASI_NEWTON: usize = 4;

/// Errors and costs of an emulator on test cases, from [`Emulator::evaluate`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Short name of the recipe.
    pub recipe: String,
    /// Errors of the predictions.
    pub raw: Errors,
    /// After one Newton step, two, and so on.
    pub corrected: Vec<Corrected>,
    /// Cost and errors of predictions as they are and after steps, from which [`Evaluation::seconds_to`] is derived.
    pub stages: Vec<Stage>,
    /// Test cases, and how often estimates of their errors hold.
    #[serde(flatten)]
    pub calibration: Calibration,
    /// Relative error of `∂û/∂θ` [%] for every parameter, medians over some cases.
    pub sensitivity_errors: Vec<f64>,
    /// Times.
    pub times: Times,
}

/// Errors after some Newton steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Corrected {
    /// Steps at most.
    pub steps: usize,
    /// Errors then; those of inverted predictions stay.
    pub errors: Errors,
    /// Cases that are farther from the truth than before.
    pub hurt: usize,
}

/// Wall times \[s\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Simulations to learn from.
    pub simulate_s: f64,
    /// Graph and coordinates.
    pub prepare_s: f64,
    /// Training.
    pub train_s: f64,
    /// One prediction with message passing.
    pub predict_full_s: f64,
    /// One prediction by the decoder alone.
    pub predict_decoder_s: f64,
    /// Time of one of many predictions made together.
    pub predict_batch_per_theta_s: f64,
    /// One Newton step; 0 where every prediction inverts a cell, so that none is made.
    pub correction_s: f64,
    /// Preparing the solver and solving from rest.
    pub solver_cold_s: f64,
    /// One solve in a sweep, from a neighbour's solution.
    pub solver_warm_s: f64,
}

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

impl Emulator<'_> {
    /// Errors on `test`, raw and after up to `corrections` Newton steps, with times.
    ///
    /// # Errors
    /// A test set without cases, or a body that cannot be solved.
    pub fn evaluate(&self, test: &TestSet<'_>, corrections: usize) -> Result<Evaluation> {
        let length = self.body.prescribed.len();
        let theta = test.thetas.first().ok_or_else(|| misfits(0, 1, length))?;
        let fields = self.predict(&test.thetas)?.fields();
        let raw = test.cases(&fields)?;
        // None where a prediction inverts a cell.
        let steps = |(theta, field): (&Vec<f64>, &Vec<f64>)| -> Result<Vec<NewtonStep>> {
            let count = corrections.max(1);
            self.solvers.with(|solver| match solver.newton_steps(field, theta, count) {
                Err(SolveError::Inadmissible { .. }) => Ok(Vec::new()),
                other => Ok(other?),
            })
        };
        let steps: Vec<_> = test.thetas.iter().zip(&fields).map(steps).collect::<Result<_>>()?;
        let calibration = Calibration::of(&ratios(self, test, &fields)?);
        let after = |count: usize| -> Vec<Vec<f64>> {
            let moved = |(field, steps): (&Vec<f64>, &Vec<NewtonStep>)| {
                let last = steps[..count.min(steps.len())].last();
                last.map_or(field, |step| &step.displacement).clone()
            };
            fields.iter().zip(&steps).map(moved).collect()
        };
        let corrected = (1..=corrections).map(|steps| {
            let cases = test.cases(&after(steps))?;
            let pairs = cases.iter().zip(&raw);
            let hurt = pairs.filter(|(after, before)| after.relative > before.relative).count();
            Ok(Corrected { steps, errors: Errors::of(&cases), hurt })
        });
        let seconds: Vec<f64> = steps.iter().flatten().map(|step| step.seconds).collect();
        let step_s = if seconds.is_empty() { 0.0 } else { median(&seconds) };
        let mut stages = vec![Stage::new(String::new(), [0.0; 2], test, &fields)];
        stages.extend(Stage::refined(self, test, step_s)?);
        stages.extend((1..=corrections.max(1)).map(|count| {
            let name = format!("{count} Newton step{}", if count == 1 { "" } else { "s" });
            Stage::new(name, [0.0, count as f64 * step_s], test, &after(count))
        }));
        Ok(Evaluation {
            stages,
            calibration,
            recipe: self.record.recipe.clone(),
            corrected: corrected.collect::<Result<_>>()?,
            raw: Errors::of(&raw),
            sensitivity_errors: self.sensitivity_errors(test)?,
            times: self.times(test, theta, step_s)?,
        })
    }

    fn times(&self, test: &TestSet<'_>, theta: &[f64], correction_s: f64) -> Result<Times> {
        let one = [theta.to_vec()];
        let many: Vec<_> = test.thetas.iter().cycle().take(BATCH).cloned().collect();
        let cold = || Solver::new(self.body)?.solve(theta, &Options::default());
        Ok(Times {
            simulate_s: self.record.simulate_s,
            prepare_s: self.record.prepare_s,
            train_s: self.record.train_s,
            predict_full_s: median_seconds(REPEATS, || {
                self.predictor.predict_in_full(self.body, &one)
            })?,
            predict_decoder_s: median_seconds(REPEATS, || self.predict(&one))?,
            predict_batch_per_theta_s: median_seconds(3, || self.predict(&many))? / BATCH as f64,
            correction_s,
            solver_cold_s: median_seconds(COLD_SOLVES, cold)?,
            solver_warm_s: test.median_solve_s,
        })
    }

    /// `∂û/∂θ` at θ: for every parameter a field, node by node [length per unit of the parameter]. Exact for a network, in
    /// forward mode through its decoders; by central differences for a regression.
    ///
    /// # Errors
    /// As [`Emulator::predict`].
    pub fn sensitivity(&self, theta: &[f64]) -> Result<Vec<Vec<f64>>> {
        check_length(self.body, theta)?;
        self.predictor.sensitivity(self.body, theta)
    }

    /// Median over the first cases of `‖∂û/∂θ − ∂u/∂θ‖ / ‖∂u/∂θ‖` [%] for every parameter, the true derivative by the implicit
    /// function theorem. The denominator is at least a thousandth of `‖u‖` over the parameter's range.
    fn sensitivity_errors(&self, test: &TestSet<'_>) -> Result<Vec<f64>> {
        let mut errors = vec![Vec::new(); self.body.parameters.len()];
        for (theta, field) in test.thetas.iter().zip(&test.fields).take(CASES) {
            let truth = self.solvers.with(|solver| {
                let solution = solver.solve_from(field, theta, &Options::default())?;
                solver.sensitivity(&solution)
            })?;
            for (p, (own, truth)) in self.sensitivity(theta)?.iter().zip(&truth).enumerate() {
                let [low, high] = self.body.parameters[p].range;
                let size = norm(truth).max(LEAST_MOTION * norm(field) / (high - low));
                let apart = 100.0 * norm(&difference(own, truth));
                errors[p].push(if size > 0.0 { apart / size } else { 0.0 });
            }
        }
        Ok(errors.iter().map(|errors| median(errors)).collect())
    }
}

impl Calibration {
    /// Calibration on the emulator's predictions for held-out cases, whose errors are returned with it.
    pub(crate) fn on(emulator: &Emulator<'_>, held_out: &TestSet<'_>) -> Result<(Self, Errors)> {
        let fields = emulator.predict(&held_out.thetas)?.fields();
        let errors = held_out.errors(&fields)?;
        Ok((Self::of(&ratios(emulator, held_out, &fields)?), errors))
    }

    fn of(judged: &[Judged]) -> Self {
        let is_near = |ratios: &&[f64; 2]| ratios.iter().all(|ratio| (0.5..=2.0).contains(ratio));
        let estimated = judged.iter().flatten().count();
        let within = judged.iter().flatten().filter(is_near).count();
        Self {
            cases: judged.len(),
            refused: judged.len() - estimated,
            inverted: judged.iter().filter(|judged| **judged == Err(true)).count(),
            within_two: within as f64 / estimated.max(1) as f64,
        }
    }
}

impl Stage {
    /// Fields on the cases of a test set.
    fn new(
        name: String,
        [once_s, each_s]: [f64; 2],
        test: &TestSet<'_>,
        fields: &[Vec<f64>],
    ) -> Self {
        let error = |(truth, field): (&Vec<f64>, &Vec<f64>)| {
            share(mean_and_largest(&difference(truth, field))[0], mean_and_largest(truth)[0])
        };
        let errors = test.fields.iter().zip(fields).map(error).collect();
        Self { name, once_s, each_s, errors }
    }

    /// After quasi-Newton steps with the stiffness at the centre of the ranges, factorised once in about the time of a Newton step; `None` if
    /// that stiffness cannot be factorised.
    fn refined(emulator: &Emulator<'_>, test: &TestSet<'_>, step_s: f64) -> Result<Option<Self>> {
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
        let one_by_one = sets < BATCH;
        let predict =
            if one_by_one { times.predict_decoder_s } else { times.predict_batch_per_theta_s };
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

/// True error over its estimate, in the energy norm and in the mean nodal distance; without an estimate, whether the prediction inverts a
/// cell.
type Judged = std::result::Result<[f64; 2], bool>;

/// True errors over their estimates, case by case.
fn ratios(emulator: &Emulator<'_>, test: &TestSet<'_>, fields: &[Vec<f64>]) -> Result<Vec<Judged>> {
    /// Rounding errors of a solve \[relative to displacements\]: a prediction that is as exact has no error to compare.
    const ROUNDING: f64 = 1e-12;
    let judge = |(case, field): (usize, &Vec<f64>)| -> Result<Judged> {
        let (theta, truth) = (&test.thetas[case], &test.fields[case]);
        let estimate = emulator.estimate_of(field, theta)?;
        let Some(distance) = estimate.distance else {
            return Ok(Err(estimate.residual.is_none()));
        };
        let apart = difference(field, truth);
        if norm(&apart) <= ROUNDING * norm(truth) {
            return Ok(Ok([1.0; 2]));
        }
        let in_energy = emulator.solvers.with(|solver| solver.energy_norm(truth, theta, &apart))?;
        let [mean, _] = mean_and_largest(&apart);
        Ok(Ok([share(in_energy, distance.energy_norm), share(mean, distance.mean)]))
    };
    try_in_parallel(fields.iter().enumerate(), judge)
}
