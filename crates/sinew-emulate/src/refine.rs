//! Newton steps from predictions: corrections by some of them, and answers to a prescribed accuracy, by as many as bring the error estimate
//! below a tolerance.

pub(crate) mod answers;
mod defects;
pub(crate) mod plan;

use crate::error::require;
use crate::estimate::evaluate::share;
use crate::parameters::{check_length, extrapolation};
use crate::predict::taylor;
use crate::refine::plan::Method;
use crate::{Body, Emulator, Estimate, Prediction, Result, Warning};
use sinew_energy::metrics::mean_and_largest;
use sinew_fem::{FrozenStiffness, NewtonStep, Solution, SolveError, Solver, Stop};
use sinew_num::{difference, dot, try_in_parallel};

/// Rounds of Newton steps at most. Each round about squares the error.
const MOST_ROUNDS: usize = 3;

/// Newton steps of a round, beyond which each step has to reduce the residual to a quarter.
pub(crate) const MOST_STEPS: usize = 4;

/// Slope of the energy along a prediction \[relative to that at rest\]. Above it, a solve from rest takes fewer steps. For
/// a linear body it is the relative error of the prediction.
const FAR: f64 = 1.0 / 3.0;

/// Displacement of a body at one parameter set, with a checked estimate of its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Displacement, node by node \[length\].
    pub displacement: Vec<f64>,
    /// Estimated error: mean nodal distance from the equilibrium, relative to the mean nodal displacement. For a solve it
    /// is the length of the Newton step that would follow.
    pub error: f64,
    /// Newton steps, each with a factorisation; 0 if quasi-Newton steps with a neighbour's stiffness were enough.
    pub steps: usize,
    /// Method that gave the prediction, or the solver.
    pub method: Method,
    /// Wall-clock time \[s\].
    pub seconds: f64,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
}

impl Answer {
    /// Whether the estimated error is below a tolerance.
    pub fn is_within(&self, accuracy: f64) -> bool {
        self.error <= accuracy
    }

    /// Whether it descends from a search that met an indefinite stiffness.
    pub fn has_jumped(&self) -> bool {
        self.warnings.contains(&Warning::Jumped)
    }

    /// The answer, with a warning where it descends from a solution that `jumped`.
    fn descended(mut self, jumped: bool) -> Self {
        if jumped && !self.has_jumped() {
            self.warnings.push(Warning::Jumped);
        }
        self
    }

    fn predicted(displacement: Vec<f64>, error: f64, steps: usize) -> Self {
        // The caller sets method, time and warnings.
        let (method, seconds, warnings) = (Method::Emulator, 0.0, Vec::new());
        Self { displacement, error, steps, method, seconds, warnings }
    }
}

/// Requires a tolerance that can be asked for.
///
/// # Errors
/// A tolerance outside 1e-10 to 0.5. Below 1e-10, rounding errors dominate.
pub(crate) fn check_accuracy(accuracy: f64) -> Result<()> {
    let advice = "give a number from 1e-10 to 0.5, such as 1e-3";
    require((1e-10..=0.5).contains(&accuracy), "the accuracy", accuracy, advice)
}

/// Answer by Newton steps from a prediction until the estimated error is below the tolerance, or `None` if they do not
/// contract; and the number of steps.
pub(crate) fn confirmed(
    solver: &mut Solver<'_>,
    predicted: &[f64],
    theta: &[f64],
    (accuracy, most): (f64, usize),
) -> Result<(Option<Answer>, usize)> {
    let mut answer = Answer::predicted(predicted.to_vec(), f64::INFINITY, 0);
    for _ in 0..MOST_ROUNDS {
        let estimate = solver.error_estimate_within(&answer.displacement, theta, most)?;
        answer.steps += estimate.newton_steps;
        let Ok(distance) = estimate.distance else { return Ok((None, answer.steps)) };
        answer.error = share(distance.left_open, mean_and_largest(&distance.equilibrium)[0]);
        answer.displacement = distance.equilibrium;
        if answer.is_within(accuracy) {
            break;
        }
    }
    let taken = answer.steps;
    Ok((Some(answer), taken))
}

/// Whether a solve from rest likely takes fewer steps than Newton's method from a displacement: its energy is not below
/// that at rest, or the slope of the energy along it is too steep for a nearby equilibrium.
pub(crate) fn is_far(body: &Body, displacement: &[f64], theta: &[f64]) -> bool {
    let mut gradient = vec![0.0; displacement.len()];
    let mut at = |u: &[f64]| {
        gradient.fill(0.0);
        let energy = body.value_and_gradient(u, theta, &mut gradient);
        (energy, dot(&gradient, displacement))
    };
    let (energy, slope) = at(displacement);
    if !body.prescribed.iter().all(|u| u.is_none_or(|u| u == 0.0)) {
        return !energy.is_finite();
    }
    let (rest, steepest) = at(&vec![0.0; displacement.len()]);
    !(energy < rest && slope.abs() <= FAR * steepest.abs())
}

impl From<Solution> for Answer {
    fn from(solution: Solution) -> Self {
        let off = solution.iteration_error.unwrap_or(f64::INFINITY);
        let is_unstable = solution.has_potential && !solution.is_stable();
        let doubts = [(solution.jumped, Warning::Jumped), (is_unstable, Warning::Unstable)];
        Self {
            error: share(off, mean_and_largest(&solution.displacement)[0]),
            steps: solution.iterations(),
            method: Method::Solver,
            seconds: solution.seconds,
            displacement: solution.displacement,
            warnings: doubts.into_iter().filter_map(|(is, doubt)| is.then_some(doubt)).collect(),
        }
    }
}

/// Mean nodal length of the first Newton step \[relative to the displacement\]. Above it, a correction may raise the error.
/// Below 2 %, every step lowered the error on the thesis' scenes.
const FAR_FOR_CORRECTION: f64 = 0.04;

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
        let refined = try_in_parallel(thetas.iter().enumerate(), refine)?;
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
        let apart = mean_and_largest(&difference(predicted, &first.displacement))[0];
        let relative = apart / mean_and_largest(&first.displacement)[0];
        let far = Warning::FarForCorrection { relative, limit: FAR_FOR_CORRECTION };
        warnings.extend((relative > FAR_FOR_CORRECTION).then_some(far));
    }
    for (step, taken) in (1..).zip(steps) {
        let (before, after, length) = (taken.residual_before, taken.residual_after, taken.length);
        warnings.extend((after > before).then_some(Warning::ResidualRose { step, before, after }));
        warnings.extend((length < 1.0).then_some(Warning::ShortStep { step, length }));
    }
    warnings
}
