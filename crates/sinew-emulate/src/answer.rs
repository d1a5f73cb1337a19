//! Answers to an accuracy: a prediction, moved by Newton steps until the checked estimate of its error is below a tolerance.

use crate::evaluate::share;
use crate::parameters::extrapolation;
use crate::{Body, Emulator, Error, Result, Warning};
use serde::{Deserialize, Serialize};
use sinew_energy::metrics::displacement_error;
use sinew_fem::{Options, Solution, Solver};
use std::time::Instant;

/// Newton steps with contraction checks that are taken before the solver starts from rest: each about squares the error.
const MOST_ROUNDS: usize = 3;

/// Quasi-Newton steps with a neighbour's stiffness before a Newton step of its own: they cost about as much as one.
const QUASI_NEWTON: usize = 6;

/// Method that an answer came by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// A prediction, and Newton steps from it that contract.
    Predicted,
    /// The solver from rest.
    Solved,
}

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
    /// Method that it came by.
    pub source: Source,
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

impl Emulator<'_> {
    /// The displacement at `theta` to a relative accuracy.
    ///
    /// The prediction is moved by Newton steps until two simplified steps after one contract and what they leave open is below the
    /// tolerance. Where they do not contract the solver starts from rest. An answer above the tolerance says so: [`Answer::is_within`].
    ///
    /// ```
    /// # use sinew_emulate::Emulator;
    /// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// # let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
    /// #     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    /// #     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    /// #     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
    /// #     .support(Support::clamped("x_min"))
    /// #     .lower()?;
    /// let emulator = Emulator::series(&beam, 1)?; // one solve, no training
    /// let answer = emulator.answer(&[60.0, 90.0], 1e-4)?;
    /// assert!(answer.is_within(1e-4) && answer.steps == 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Emulator::predict`], an accuracy outside 1e-10 to 0.5, no equilibrium.
    pub fn answer(&self, theta: &[f64], accuracy: f64) -> Result<Answer> {
        check_accuracy(accuracy)?;
        let start = Instant::now();
        let predicted = self.predict(&[theta.to_vec()])?.displacement;
        let mut answer =
            self.with_solver(|solver| match confirmed(solver, &predicted, theta, accuracy)? {
                Some(answer) => Ok(answer),
                None => Ok(solver.solve(theta, &Options::default())?.into()),
            })?;
        answer.warnings.extend(extrapolation(self.body, theta));
        answer.seconds = start.elapsed().as_secs_f64();
        Ok(answer)
    }
}

/// An answer from a prediction by quasi-Newton steps with the stiffness that the solver factorised last; `None` where they do not contract.
pub(crate) fn converged(
    solver: &Solver<'_>,
    predicted: &[f64],
    theta: &[f64],
    accuracy: f64,
) -> Result<Option<Answer>> {
    let start = Instant::now();
    let found = solver.converge(predicted, theta, accuracy, QUASI_NEWTON)?;
    Ok(found.map(|found| Answer {
        displacement: found.displacement,
        error: found.error,
        steps: 0,
        source: Source::Predicted,
        seconds: start.elapsed().as_secs_f64(),
        warnings: Vec::new(),
    }))
}

/// An answer from a prediction by Newton steps; `None` where they do not contract.
pub(crate) fn confirmed(
    solver: &mut Solver<'_>,
    predicted: &[f64],
    theta: &[f64],
    accuracy: f64,
) -> Result<Option<Answer>> {
    let (start, mut steps) = (Instant::now(), 0);
    let found = contract(solver, predicted, theta, accuracy, &mut steps)?;
    Ok(found.map(|(displacement, error)| Answer {
        displacement,
        error,
        steps,
        source: Source::Predicted,
        seconds: start.elapsed().as_secs_f64(),
        warnings: Vec::new(),
    }))
}

impl From<Solution> for Answer {
    fn from(solution: Solution) -> Self {
        Self {
            error: share(solution.residual, solution.force_scale),
            steps: solution.iterations(),
            source: Source::Solved,
            seconds: solution.seconds,
            displacement: solution.displacement,
            warnings: if solution.jumped { vec![Warning::Jumped] } else { Vec::new() },
        }
    }
}

/// Newton steps from a displacement until what their contraction leaves open is below the tolerance, with that error; `None` where they do
/// not contract.
fn contract(
    solver: &mut Solver<'_>,
    from: &[f64],
    theta: &[f64],
    accuracy: f64,
    steps: &mut usize,
) -> Result<Option<(Vec<f64>, f64)>> {
    let mut found: Option<(Vec<f64>, f64)> = None;
    for _ in 0..MOST_ROUNDS {
        let from = found.as_ref().map_or(from, |(displacement, _)| displacement);
        let estimate = solver.error_estimate(from, theta)?;
        *steps += estimate.newton_steps;
        let Ok(distance) = estimate.distance else { return Ok(None) };
        let error = relative(solver.body(), distance.left_open, &distance.equilibrium);
        let reached = error <= accuracy;
        found = Some((distance.equilibrium, error));
        if reached {
            break;
        }
    }
    Ok(found)
}

/// A mean nodal distance relative to the mean nodal displacement; zero of nothing.
fn relative(body: &Body, distance: f64, displacement: &[f64]) -> f64 {
    let nodal = displacement_error(displacement, &vec![0.0; displacement.len()]);
    let mean = nodal.iter().sum::<f64>() / body.nodes.max(1) as f64;
    share(distance, mean)
}
