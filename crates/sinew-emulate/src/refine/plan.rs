//! The planner: many parameter sets to an accuracy, by the method that costs least.

use crate::parameters::check_length;
use crate::recipe::progress::{Counter, Observer};
use crate::refine::{MOST_STEPS, check_accuracy, confirmed};
use crate::sample::simulate::LARGEST_COMPARED;
use crate::{Body, Emulator, Result, Warning};
use serde::{Deserialize, Serialize};
use sinew_fem::{CHAIN, Options, Solution, Solver};

/// Parameter sets below which no cost is measured, because measuring takes two solves. An emulator answers if there is one,
/// else the solver.
pub(crate) const FEW: usize = 4;

/// Cost of an answer from a prediction [Newton steps]: three quasi-Newton steps with a neighbour's stiffness, and a Newton
/// step where these do not contract (measured: 0.3 for a left ventricle, 0.5 over a decade of stiffness).
const ANSWER: f64 = 0.5;

/// Cost of a solve in a sweep, with its quasi-Newton steps [Newton steps]. Neighbours are nearer than the centre of the
/// ranges (measured: 2.3 factorisations per set for beams, 3.5 for ventricles).
pub(crate) const SWEPT: f64 = 4.0;

/// Accuracy of the solution that an expansion is about, where an emulator predicts it first: far below the error of the expansion.
const CENTRE: f64 = 1e-8;

/// A method that can answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The solver, each set on its own.
    Solver,
    /// A Taylor expansion about one solve at the centre of the ranges, and steps that contract.
    Expansion,
    /// A regression of other answers, and steps that contract.
    Regression,
    /// An emulator that is there already, and steps that contract.
    Emulator,
}

impl Method {
    /// Name for tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solver => "solver",
            Self::Expansion => "expansion + Newton steps",
            Self::Regression => "regression + Newton steps",
            Self::Emulator => "emulator + Newton steps",
        }
    }
}

/// Expected cost of a method in Newton steps, a factorisation each; not a number where nothing was measured.
///
/// The choice is made by these, so that it depends neither on the machine nor on its threads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// The method.
    pub method: Method,
    /// Newton steps before the first answer.
    pub prepare: f64,
    /// Newton steps of an answer.
    pub each: f64,
}

/// Costs of the methods for a number of parameter sets, from two solves whose Newton steps were counted and timed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Parameter sets.
    pub sets: usize,
    /// Tolerance: mean nodal error relative to the mean nodal displacement.
    pub accuracy: f64,
    /// Wall time of a Newton step \[s\]; `None` where nothing was measured.
    pub step_s: Option<f64>,
    /// Methods, the one with the fewest expected Newton steps first.
    pub costs: Vec<Cost>,
}

impl Plan {
    /// Plans for several numbers of parameter sets near one of them. Counts the Newton steps of a solve at the centre of the ranges and of
    /// one from there to that set, and times the second, once for all numbers.
    ///
    /// An `emulator` gives the initial guess of the solve at the centre. Its own preparation counts as zero.
    ///
    /// # Errors
    /// An accuracy outside 1e-10 to 0.5, θ of the wrong length, an observer that breaks.
    pub fn for_counts(
        body: &Body,
        theta: &[f64],
        counts: &[usize],
        accuracy: f64,
        emulator: Option<&Emulator<'_>>,
        observer: &mut dyn Observer,
    ) -> Result<Vec<Self>> {
        check_accuracy(accuracy)?;
        check_length(body, theta)?;
        let mut counter = Counter::new(observer, "plan", 0, 1);
        let counted = Counted::measure(body, theta, emulator, &mut counter)?;
        counter.check()?;
        counter.finish("solved twice");
        let plan = |&sets: &usize| Self::of(counted.as_ref(), body, sets, accuracy, emulator);
        Ok(counts.iter().map(plan).collect())
    }

    /// The plan for some parameter sets; measures no cost below four of them. Also returns the solution at the centre of the ranges if one
    /// was computed.
    pub(crate) fn quick<'b>(
        body: &'b Body,
        thetas: &[Vec<f64>],
        accuracy: f64,
        emulator: Option<&Emulator<'_>>,
        counter: &mut Counter<'_>,
    ) -> Result<(Self, Option<Counted<'b>>)> {
        check_accuracy(accuracy)?;
        thetas.iter().try_for_each(|theta| check_length(body, theta))?;
        let sets = thetas.len();
        let (Some(theta), true) = (thetas.first(), sets >= FEW) else {
            let method = if emulator.is_some() { Method::Emulator } else { Method::Solver };
            return Ok((Self::unmeasured(sets, accuracy, method), None));
        };
        let counted = Counted::measure(body, theta, emulator, counter)?;
        Ok((Self::of(counted.as_ref(), body, sets, accuracy, emulator), counted))
    }

    fn unmeasured(sets: usize, accuracy: f64, method: Method) -> Self {
        let costs = vec![Cost { method, prepare: f64::NAN, each: f64::NAN }];
        Self { sets, accuracy, step_s: None, costs }
    }

    fn of(
        counted: Option<&Counted<'_>>,
        body: &Body,
        sets: usize,
        accuracy: f64,
        emulator: Option<&Emulator<'_>>,
    ) -> Self {
        let Some(counted) = counted else {
            return Self::unmeasured(sets, accuracy, Method::Solver);
        };
        let each = if sets < CHAIN { counted.near } else { counted.near.min(SWEPT) };
        let mut costs = vec![Cost { method: Method::Solver, prepare: 0.0, each }];
        if !body.parameters.is_empty() {
            // A solve, and a state for each parameter and each pair of parameters.
            let count = body.parameters.len() as f64;
            let prepare = counted.centre + 1.0 + count + count * (count + 1.0);
            costs.push(Cost { method: Method::Expansion, prepare, each: ANSWER });
        }
        if let Some(emulator) = emulator {
            let each = ANSWER + emulator.predictor.newton_steps();
            costs.push(Cost { method: Method::Emulator, prepare: 0.0, each });
        }
        costs.sort_by(|a, b| a.newton_steps(sets).total_cmp(&b.newton_steps(sets)));
        let step_s = counted.first.seconds / counted.first.iterations().max(1) as f64;
        Self { sets, accuracy, step_s: Some(step_s), costs }
    }

    /// The method that is taken.
    pub fn method(&self) -> Method {
        self.costs[0].method
    }

    /// Expected wall time of so many Newton steps \[s\]; `None` where nothing was measured.
    pub fn seconds(&self, newton_steps: f64) -> Option<f64> {
        self.step_s.map(|step_s| step_s * newton_steps)
    }

    /// Threads that answer side by side.
    pub fn threads(&self) -> usize {
        rayon::current_num_threads().min(self.sets.max(1))
    }

    /// Expected wall time of all answers by a method on [`Plan::threads`] \[s\]; `None` where nothing was measured.
    pub fn total_s(&self, cost: &Cost) -> Option<f64> {
        self.seconds(cost.prepare + cost.each * self.sets as f64 / self.threads() as f64)
    }
}

impl Cost {
    /// Expected Newton steps of preparation and so many answers.
    pub fn newton_steps(&self, sets: usize) -> f64 {
        self.prepare + self.each * sets as f64
    }
}

/// Newton steps and seconds that a plan is made of, and the solution at the centre of the ranges.
pub(crate) struct Counted<'b> {
    /// Newton steps of a solve near to another one.
    near: f64,
    /// Newton steps of the solve at the centre.
    centre: f64,
    /// Equilibrium at the first parameter set.
    pub first: Solution,
    pub solver: Solver<'b>,
    /// Displacement at the centre, node by node \[length\].
    pub displacement: Vec<f64>,
    /// Whether it may be on another branch than that of a rising load, or its neighbours.
    pub jumped: bool,
}

impl<'b> Counted<'b> {
    /// `None` where the body has no equilibrium at the centre or at `theta`.
    fn measure(
        body: &'b Body,
        theta: &[f64],
        emulator: Option<&Emulator<'_>>,
        counter: &mut Counter<'_>,
    ) -> Result<Option<Self>> {
        let (mut solver, options) = (Solver::new(body)?, Options::default());
        let solved = at_centre(&mut solver, emulator, counter)?;
        let Some((centre, displacement, jumped)) = solved else { return Ok(None) };
        let Ok(first) = solver.solve_from(&displacement, theta, &options) else { return Ok(None) };
        let near = first.iterations() as f64;
        // A solve from rest may take fewer, and one at the centre itself tells nothing.
        let near = match near {
            ..2.0 => near.max(centre),
            _ if emulator.is_none() => near.min(centre),
            _ => near,
        };
        Ok(Some(Self { near, centre, first, solver, displacement, jumped }))
    }
}

/// Newton steps taken and displacement at the centre of the ranges: from an emulator's prediction if steps from it
/// contract, else from rest; and whether it may be on another branch than that of a rising load. `None` if there is no equilibrium.
fn at_centre(
    solver: &mut Solver<'_>,
    emulator: Option<&Emulator<'_>>,
    counter: &mut Counter<'_>,
) -> Result<Option<(f64, Vec<f64>, bool)>> {
    let centre = solver.body().centre();
    let mut steps = 0.0;
    if let Some(emulator) = emulator {
        steps = emulator.predictor.newton_steps();
        if let Ok(predicted) = emulator.predict(std::slice::from_ref(&centre)) {
            let within = (CENTRE, MOST_STEPS);
            let (found, taken) = confirmed(solver, &predicted.displacement, &centre, within)?;
            steps += taken as f64;
            if let Some(found) = found {
                return Ok(Some((steps, found.displacement, has_branches(emulator))));
            }
        }
    }
    // A break shows after the first answers.
    let mut watch = |state: &sinew_fem::Progress<'_>| {
        let _ = counter.within(|| state.in_words());
    };
    let solved = solver.solve_watched(&centre, &Options::default(), &mut watch);
    let Ok(found) = solved else { return Ok(None) };
    let steps = steps + found.iterations() as f64;
    let (displacement, jumped) = risen(solver, found);
    Ok(Some((steps, displacement, jumped)))
}

/// Whether an emulator learnt from solutions that a rising load does not lead to.
pub(crate) fn has_branches(emulator: &Emulator<'_>) -> bool {
    let branches = |warning: &Warning| matches!(warning, Warning::SeveralEquilibria { .. });
    emulator.record.warnings.iter().any(branches)
}

/// The equilibrium of a rising load in the place of one that jumped, where there is one and the body is not too large for it; and whether
/// answers from it get a mark: under other parameters a rising load may lead to another branch.
fn risen(solver: &mut Solver<'_>, found: Solution) -> (Vec<f64>, bool) {
    if !found.jumped || solver.unknowns() > LARGEST_COMPARED {
        return (found.displacement, found.jumped);
    }
    let risen = solver.under_rising_load(&found, &Options::default(), &mut |_| ());
    (risen.ok().flatten().unwrap_or(found).displacement, true)
}
