//! Answers to a prescribed accuracy: Newton steps from a prediction until the error estimate is below a tolerance.

pub(crate) mod answers;
pub(crate) mod correction;
mod defects;
pub(crate) mod plan;

use crate::error::require;
use crate::estimate::evaluate::share;
use crate::refine::plan::Method;
use crate::{Body, Result, Warning};
use sinew_energy::metrics::mean_and_largest;
use sinew_fem::{Solution, Solver};

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
        let Ok(distance) = estimate.distance else {
            return Ok((None, answer.steps));
        };
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
        let slope: f64 = gradient.iter().zip(displacement).map(|(g, u)| g * u).sum();
        (energy, slope)
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
        Self {
            error: share(
                solution.iteration_error.unwrap_or(f64::INFINITY),
                mean_and_largest(&solution.displacement)[0],
            ),
            steps: solution.iterations(),
            method: Method::Solver,
            seconds: solution.seconds,
            displacement: solution.displacement,
            warnings: if solution.jumped { vec![Warning::Jumped] } else { Vec::new() },
        }
    }
}
