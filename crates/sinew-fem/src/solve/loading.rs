//! The whole load: at once where that works, else by load steps, unless evidence says that the body does not bear it.

use crate::elements::system::Unknowns;
use crate::solve::path::{FIRST_GRADIENT, Path};
use crate::solve::search::{Equilibrium, Goal, Start};
use crate::solve::watch::Log;
use crate::{Advice, LoadSteps, SolveError};
use std::ops::Range;

/// A body that does not minimise a potential starts in steps where the linear model foresees that the whole load changes a
/// displacement gradient by more than this: beams under a loose pressure wasted five iterations on the attempt.
const FAR: f64 = 2.5;
/// Parts of a load beyond the limit: where an attempt at it fails, the whole load is far beyond what a body bears if the linear model foresees displacement gradients of more
/// than 1e4, as a first step in this range says. The softest ventricle under 1000 mmHg, which is solved, has 6e-4. Below are loads near
/// overflow, which exponential laws may bear.
const FAR_BEYOND: Range<f64> = 1e-9..2.5e-5;
/// Iterations of the search for the part of such a load that the body bears, and the least number after the attempt at all of it.
const GLANCE: [usize; 2] = [50, 15];
/// Steps in a row with an indefinite stiffness after which the first load steps are taken before more of the whole load's: they tell bodies that
/// come to rest far away from those that never will.
const PATIENCE: usize = 10;
/// Iterations that these load steps get: two beyond what ventricles take to their limit pressure.
const SCOUT: usize = 48;

impl Path<'_, '_> {
    /// The equilibrium under the whole load with the number of load steps: at once from where it should be, or else by
    /// steps from rest.
    ///
    /// # Errors
    /// [`SolveError::NotConverged`].
    pub(crate) fn run(
        mut self,
        from: Unknowns,
        history: &mut Log<'_>,
    ) -> Result<(Equilibrium, usize), SolveError> {
        let steps_allowed = self.options.least_load_step <= self.options.first_load_step;
        if self.options.load_steps == LoadSteps::Always || (steps_allowed && self.rolls_up(&from)) {
            let step = self.first_step();
            let far =
                self.options.load_steps == LoadSteps::WhenNeeded && FAR_BEYOND.contains(&step);
            return if far { self.glance(step, history) } else { self.by_steps(step, history) };
        }
        let patience = if steps_allowed { PATIENCE } else { usize::MAX };
        if let Some(found) = self.at_once(&from, patience, history) {
            return Ok((found, 1));
        }
        if history.iterations.len() >= self.options.iterations || !steps_allowed {
            return Err(self.failure(None, history));
        }
        let step = self.first_step();
        if FAR_BEYOND.contains(&step) {
            return self.glance(step, history);
        }
        if history.indefinite() >= PATIENCE {
            if self.softer_volume().is_none() {
                self.outlook.refuse(1.0);
                match self.scout(step, history) {
                    Err(None) => {}
                    found => return found.map_err(|advice| self.failure(advice, history)),
                }
            }
            if let Some(found) = self.at_once(&from, usize::MAX, history) {
                return Ok((found, 1));
            }
        }
        let tried = history.iterations.clone();
        if let Some(found) = self.by_softer_volume(history) {
            return Ok(found);
        }
        history.iterations = tried;
        self.by_steps(step, history)
    }

    /// Whether a balance of a body at rest goes so far that an attempt at the whole load is wasted.
    fn rolls_up(&mut self, from: &Unknowns) -> bool {
        let balance = !self.system.has_potential() && *from == self.system.rest();
        balance && self.first_step() < FIRST_GRADIENT / FAR
    }

    /// The equilibrium under the whole load, near to a state.
    pub(crate) fn at_once(
        &mut self,
        from: &Unknowns,
        most_indefinite: usize,
        history: &mut Log<'_>,
    ) -> Option<Equilibrium> {
        let start = Start { unknowns: from.clone(), place: 1.0, stress: None };
        let accuracy = self.accuracy();
        let goal = Goal { line: &self.line, control: None, accuracy, most_indefinite };
        self.system.equilibrium(start, goal, &self.options, history)
    }

    /// Some load steps, which may meet a limit point.
    fn scout(
        &mut self,
        step: f64,
        history: &mut Log<'_>,
    ) -> Result<(Equilibrium, usize), Option<Advice>> {
        let all = self.options.iterations;
        self.options.iterations = all.min(history.iterations.len() + SCOUT);
        self.release_stresses();
        let found = self.steps(1.0, step, history);
        self.options.iterations = all;
        found
    }

    /// The equilibrium by load steps from where the path has come to.
    fn by_steps(
        &mut self,
        step: f64,
        history: &mut Log<'_>,
    ) -> Result<(Equilibrium, usize), SolveError> {
        self.release_stresses();
        // After some steps the next are as long as the last allow.
        let step = if self.points.len() > 1 { 1.0 } else { step };
        self.follow(1.0, step, history)
    }

    /// Part that the body bears of a load far beyond its limit.
    fn glance(
        &mut self,
        step: f64,
        history: &mut Log<'_>,
    ) -> Result<(Equilibrium, usize), SolveError> {
        self.release_stresses();
        let [all, more] = GLANCE;
        let most = all.max(history.iterations.len() + more);
        self.options.iterations = most.min(self.options.iterations);
        let far = Advice::FarBeyond { times: 1.0 / step };
        self.steps(1.0, step, history)
            .map_err(|advice| self.failure(Some(advice.unwrap_or(far)), history))
    }
}
