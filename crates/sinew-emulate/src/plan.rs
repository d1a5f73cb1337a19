//! The planner: many parameter sets to an accuracy, by the method that costs least.

use crate::answer::check_accuracy;
use crate::parameters::check_length;
use crate::{Body, Emulator, Result};
use serde::{Deserialize, Serialize};
use sinew_fem::{Options, Solver};

/// Parameter sets below which the solver answers without a look at the alternatives: measuring them takes two solves.
const FEW: usize = 4;

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
}

/// Costs of the methods for a number of parameter sets, from solves that were timed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Parameter sets.
    pub sets: usize,
    /// Tolerance: mean nodal error relative to the mean nodal displacement.
    pub accuracy: f64,
    /// Methods, the one with the least expected time first.
    pub costs: Vec<Cost>,
}

impl Plan {
    /// Times a solve from rest and one from its result at the centre of the ranges and at a parameter set, and a checked Newton step.
    ///
    /// A `trained` emulator's own costs are steps alone. Below four sets without one the solver is taken at once.
    ///
    /// # Errors
    /// An accuracy outside 1e-10 to 0.5, θ of the wrong length.
    pub fn new(
        body: &Body,
        thetas: &[Vec<f64>],
        accuracy: f64,
        trained: Option<&Emulator<'_>>,
    ) -> Result<Self> {
        check_accuracy(accuracy)?;
        thetas.iter().try_for_each(|theta| check_length(body, theta))?;
        let sets = thetas.len();
        let plan = |costs| Ok(Self { sets, accuracy, costs });
        let alone = |method| Cost { method, prepare_s: 0.0, each_s: f64::NAN, total_s: f64::NAN };
        if sets < FEW {
            let method = if trained.is_some() { Method::Emulator } else { Method::Solver };
            return plan(vec![alone(method)]);
        }
        let Some(timed) = Timed::measure(body, &thetas[0])? else {
            return plan(vec![alone(Method::Solver)]);
        };
        let threads = rayon::current_num_threads() as f64;
        let cost = |method, prepare_s: f64, each_s: f64| {
            let total_s = prepare_s + each_s * sets as f64 / threads.min(sets as f64);
            Cost { method, prepare_s, each_s, total_s }
        };
        let mut costs = vec![cost(Method::Solver, 0.0, timed.solve_s)];
        if !body.parameters.is_empty() {
            costs.push(cost(Method::Expansion, timed.expansion_s(body), timed.checked_s));
        }
        if trained.is_some() {
            costs.push(cost(Method::Emulator, 0.0, timed.checked_s));
        }
        costs.sort_by(|a, b| a.total_s.total_cmp(&b.total_s));
        plan(costs)
    }

    /// The method that is taken.
    pub fn method(&self) -> Method {
        self.costs[0].method
    }
}

/// Seconds that a plan is made of.
struct Timed {
    /// A solve near to another one.
    solve_s: f64,
    /// A solve from rest.
    rest_s: f64,
    /// A Newton step with its check.
    checked_s: f64,
}

impl Timed {
    /// `None` where the body has no equilibrium at the centre or at `theta`.
    fn measure(body: &Body, theta: &[f64]) -> Result<Option<Self>> {
        let (mut solver, options) = (Solver::new(body)?, Options::default());
        let Ok(centre) = solver.solve(&body.centre(), &options) else { return Ok(None) };
        let Ok(near) = solver.solve_from(&centre.displacement, theta, &options) else {
            return Ok(None);
        };
        let checked = solver.error_estimate(&near.displacement, theta)?;
        Ok(Some(Self {
            solve_s: near.seconds.min(centre.seconds),
            rest_s: centre.seconds,
            checked_s: checked.seconds,
        }))
    }

    /// Time of a Taylor expansion of second order: a solve, derivatives by one and two parameters, and their trial.
    fn expansion_s(&self, body: &Body) -> f64 {
        let count = body.parameters.len() as f64;
        let states = 1.0 + count + count * (count + 1.0);
        self.rest_s + states * self.checked_s / STATES_A_STEP
    }
}

/// Derivatives that take as long as a Newton step with its check (measured on a beam of 741 and a ventricle of 1570 nodes).
const STATES_A_STEP: f64 = 1.0;
