//! Answers to an accuracy: a prediction, moved by Newton steps until the checked estimate of its error is below a tolerance.

use crate::evaluate::share;
use crate::plan::Method;
use crate::{Body, Error, Result, Warning};
use sinew_energy::metrics::displacement_error;
use sinew_fem::{Solution, Solver};

/// Newton steps with contraction checks that are taken before the solver starts from rest: each about squares the error.
const MOST_ROUNDS: usize = 3;

/// Newton steps of a round that may not contract.
pub(crate) const MOST_STEPS: usize = 4;

/// Slope of the energy along a prediction relative to that at rest, from which on the solver takes fewer steps from rest: it is the share by which its
/// size is off, for a linear body.
const FAR: f64 = 1.0 / 3.0;

/// Quasi-Newton steps with a neighbour's stiffness before a Newton step of its own: they cost about as much as one.
const QUASI_NEWTON: usize = 6;

/// Displacement of a body at one parameter set, with a checked estimate of its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Displacement, node by node \[length\].
    pub displacement: Vec<f64>,
    /// Estimated error: mean nodal distance from the equilibrium, relative to the mean nodal displacement. That of a solve is what rounding
    /// errors leave of its forces, relative to loads and reactions.
    pub error: f64,
    /// Newton steps behind it, a factorisation each; none where quasi-Newton steps with a neighbour's stiffness were enough.
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
}

/// Requires a tolerance that can be asked for.
///
/// # Errors
/// One outside 1e-10 to 0.5: below it, rounding errors decide.
pub(crate) fn check_accuracy(accuracy: f64) -> Result<()> {
    let (what, advice) = ("the accuracy", "give a number from 1e-10 to 0.5, such as 1e-3");
    let makes_sense = (1e-10..=0.5).contains(&accuracy);
    if makes_sense { Ok(()) } else { Err(Error::Setting { what, value: accuracy, advice }) }
}

/// An answer from a prediction by quasi-Newton steps with the stiffness that the solver factorised last, and how many of them; `None` where they do not
/// contract. They may have been seen to contract at a neighbour.
pub(crate) fn converged(
    solver: &Solver<'_>,
    predicted: &[f64],
    theta: &[f64],
    (accuracy, seen): (f64, bool),
) -> Result<Option<(Answer, usize)>> {
    let found = match seen {
        true => solver.converge_near(predicted, theta, accuracy, QUASI_NEWTON)?,
        false => solver.converge(predicted, theta, accuracy, QUASI_NEWTON)?,
    };
    Ok(found.map(|found| (Answer::predicted(found.displacement, found.error, 0), found.steps)))
}

/// An answer from a prediction by Newton steps until what their contraction leaves open is below the tolerance, `None` where they do not
/// contract; and how many were taken.
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
        answer.error = relative(solver.body(), distance.left_open, &distance.equilibrium);
        answer.displacement = distance.equilibrium;
        if answer.is_within(accuracy) {
            break;
        }
    }
    let taken = answer.steps;
    Ok((Some(answer), taken))
}

/// Whether a solve from rest is likely to take fewer steps than Newton's method from a displacement: its energy is not below that at rest, or has a slope
/// along it that an equilibrium nearby would not have.
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

impl Answer {
    fn predicted(displacement: Vec<f64>, error: f64, steps: usize) -> Self {
        // The caller says which method and when.
        let (method, seconds, warnings) = (Method::Emulator, 0.0, Vec::new());
        Self { displacement, error, steps, method, seconds, warnings }
    }
}

impl From<Solution> for Answer {
    fn from(solution: Solution) -> Self {
        Self {
            error: share(solution.residual, solution.force_scale),
            steps: solution.iterations(),
            method: Method::Solver,
            seconds: solution.seconds,
            displacement: solution.displacement,
            warnings: if solution.jumped { vec![Warning::Jumped] } else { Vec::new() },
        }
    }
}

/// A mean nodal distance relative to the mean nodal displacement; zero of nothing.
fn relative(body: &Body, distance: f64, displacement: &[f64]) -> f64 {
    let nodal = displacement_error(displacement, &vec![0.0; displacement.len()]);
    let mean = nodal.iter().sum::<f64>() / body.nodes.max(1) as f64;
    share(distance, mean)
}
