//! The planner: many parameter sets to an accuracy, by the method that costs least.

use crate::answer::check_accuracy;
use crate::parameters::check_length;
use crate::{Body, Emulator, Result};
use serde::{Deserialize, Serialize};
use sinew_fem::{Options, Solver};

/// Parameter sets below which the solver answers without a look at the alternatives: measuring them takes two solves.
const FEW: usize = 4;

/// Newton steps that an answer from a prediction costs as much as: three quasi-Newton steps with a neighbour's stiffness, and a Newton step for
/// the sets at which these do not contract (measured: 0.3 for a left ventricle, 0.5 over a decade of stiffness).
const ANSWER: f64 = 0.5;

/// A method that can answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The solver, each set on its own.
    Solver,
    /// A Taylor expansion about one solve at the centre of the ranges, and Newton steps.
    Expansion,
    /// An emulator that is trained already, and Newton steps.
    Emulator,
}

impl Method {
    /// For tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solver => "solver",
            Self::Expansion => "expansion + Newton steps",
            Self::Emulator => "trained emulator + Newton steps",
        }
    }
}

/// Cost of a method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// The method.
    pub method: Method,
    /// Time before the first answer \[s\].
    pub prepare_s: f64,
    /// Time of an answer on one thread \[s\].
    pub each_s: f64,
    /// Expected wall time of all answers on the threads there are \[s\].
    pub total_s: f64,
    /// Expected Newton steps of preparation and all answers, a factorisation each: the choice is made by them, so that it depends neither
    /// on the machine nor on its threads.
    pub newton_steps: f64,
}

/// Costs of the methods for a number of parameter sets, from two solves and a Newton step that were counted and timed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Parameter sets.
    pub sets: usize,
    /// Tolerance: mean nodal error relative to the mean nodal displacement.
    pub accuracy: f64,
    /// Methods, the one with the fewest expected Newton steps first.
    pub costs: Vec<Cost>,
}

impl Plan {
    /// Counts the Newton steps of a solve from rest at the centre of the ranges and of one from there to the first parameter set, and times a
    /// checked Newton step.
    ///
    /// A `trained` emulator's own costs are steps alone.
    ///
    /// # Errors
    /// An accuracy outside 1e-10 to 0.5, θ of the wrong length.
    pub fn new(
        body: &Body,
        thetas: &[Vec<f64>],
        accuracy: f64,
        trained: Option<&Emulator<'_>>,
    ) -> Result<Self> {
        Ok(Self::measured(body, thetas, accuracy, trained, 1)?.0)
    }

    /// For answers: below four sets nothing is measured. With the solution at the centre of the ranges where one was needed.
    pub(crate) fn quick<'b>(
        body: &'b Body,
        thetas: &[Vec<f64>],
        accuracy: f64,
        trained: Option<&Emulator<'_>>,
    ) -> Result<(Self, Option<Centre<'b>>)> {
        Self::measured(body, thetas, accuracy, trained, FEW)
    }

    fn measured<'b>(
        body: &'b Body,
        thetas: &[Vec<f64>],
        accuracy: f64,
        trained: Option<&Emulator<'_>>,
        fewest: usize,
    ) -> Result<(Self, Option<Centre<'b>>)> {
        check_accuracy(accuracy)?;
        thetas.iter().try_for_each(|theta| check_length(body, theta))?;
        let sets = thetas.len();
        let plan = |costs, centre| Ok((Self { sets, accuracy, costs }, centre));
        let alone = |method| Cost {
            method,
            prepare_s: 0.0,
            each_s: f64::NAN,
            total_s: f64::NAN,
            newton_steps: f64::NAN,
        };
        if sets < fewest {
            let method = if trained.is_some() { Method::Emulator } else { Method::Solver };
            return plan(vec![alone(method)], None);
        }
        let Some((timed, centre)) = Timed::measure(body, &thetas[0])? else {
            return plan(vec![alone(Method::Solver)], None);
        };
        let threads = rayon::current_num_threads() as f64;
        let cost = |method, prepare: f64, each: f64| {
            let (prepare_s, each_s) = (prepare * timed.step_s, each * timed.step_s);
            let total_s = prepare_s + each_s * sets as f64 / threads.min(sets as f64);
            Cost { method, prepare_s, each_s, total_s, newton_steps: prepare + each * sets as f64 }
        };
        let mut costs = vec![cost(Method::Solver, 0.0, timed.near)];
        if !body.parameters.is_empty() {
            costs.push(cost(Method::Expansion, timed.expansion(body), ANSWER));
        }
        if trained.is_some() {
            costs.push(cost(Method::Emulator, 0.0, ANSWER));
        }
        costs.sort_by(|a, b| a.newton_steps.total_cmp(&b.newton_steps));
        plan(costs, Some(centre))
    }

    /// The method that is taken.
    pub fn method(&self) -> Method {
        self.costs[0].method
    }
}

/// Solution at the centre of the ranges.
pub(crate) struct Centre<'b> {
    pub solver: Solver<'b>,
    /// Displacement, node by node \[length\].
    pub displacement: Vec<f64>,
}

/// Newton steps and seconds that a plan is made of.
struct Timed {
    /// Newton steps of a solve near to another one.
    near: f64,
    /// Newton steps of a solve from rest.
    rest: f64,
    /// A Newton step with its check \[s\].
    step_s: f64,
}

impl Timed {
    /// `None` where the body has no equilibrium at the centre or at `theta`.
    fn measure<'b>(body: &'b Body, theta: &[f64]) -> Result<Option<(Self, Centre<'b>)>> {
        let (mut solver, options) = (Solver::new(body)?, Options::default());
        let Ok(centre) = solver.solve(&body.centre(), &options) else { return Ok(None) };
        let Ok(near) = solver.solve_from(&centre.displacement, theta, &options) else {
            return Ok(None);
        };
        let checked = solver.error_estimate(&near.displacement, theta)?;
        let [rest, near] = [&centre, &near].map(|found| found.iterations() as f64);
        let step_s = checked.seconds / checked.newton_steps.max(1) as f64;
        let timed = Self { near: near.min(rest), rest, step_s };
        Ok(Some((timed, Centre { solver, displacement: centre.displacement })))
    }

    /// Newton steps that a Taylor expansion of second order costs as much as: a solve, and a state for the derivatives by each parameter and each two of them.
    fn expansion(&self, body: &Body) -> f64 {
        let count = body.parameters.len() as f64;
        self.rest + 1.0 + count + count * (count + 1.0)
    }
}
