//! Solving under the whole load: at once if possible, else by load increments, unless the load is beyond a limit point.
//! Nearly incompressible bodies are also reached through one with a smaller bulk modulus.

use crate::elements::Unknowns;
use crate::solve::{Equilibrium, FIRST_GRADIENT, FIRST_STEP, Goal, Path, Point};
use crate::{Advice, LoadSteps, Result};
use sinew_energy::Body;
use std::ops::Range;

/// Change of a displacement gradient under the whole load, by the linear model, above which a balance without a
/// potential starts with load increments: beams under a pressure with a loose rim lose five iterations otherwise.
const FAR: f64 = 2.5;
/// First load steps of loads far beyond the limit: a step below 2.5e-5 means displacement gradients above 1e4 in the
/// linear model. The softest ventricle under 1000 mmHg, which is solved, has 6e-4. Loads below the range are near
/// overflow; exponential laws may bear them.
const FAR_BEYOND: Range<f64> = 1e-9..2.5e-5;
/// Iterations to find the part of such a load that the body bears: in all, and at least after the attempt at the whole
/// load.
const GLANCE: [usize; 2] = [50, 15];
/// Successive steps with an indefinite stiffness after which load increments are tried before the whole load is
/// continued: they tell whether an equilibrium exists. Where the law has a bulk modulus, the search goes on.
const PATIENCE: usize = 10;
/// Iterations of these load increments: two more than ventricles need to their limit pressure.
const SCOUT: usize = 48;

/// Factor of the bulk modulus of the softer body, which needs a handful of iterations.
const SOFTER: f64 = 1e-2;
/// The load steps of the softer body get one half of all iterations.
const DETOUR: usize = 2;

impl Path<'_, '_, '_> {
    /// The equilibrium under the whole load and the number of load steps: at once from a given state, else by steps
    /// from rest.
    ///
    /// # Errors
    /// [`crate::SolveError::NotConverged`].
    pub(crate) fn run(&mut self, from: Unknowns) -> Result<(Equilibrium, usize)> {
        let steps_allowed = self.options.least_load_step <= FIRST_STEP;
        let always = self.options.load_steps == LoadSteps::Always;
        if always || (steps_allowed && self.rolls_up(&from)) {
            let step = self.first_step();
            let far = !always && FAR_BEYOND.contains(&step);
            return if far { self.glance(step) } else { self.by_steps(step, None) };
        }
        let scouted = steps_allowed && self.softer_volume().is_none();
        let patience = if scouted { PATIENCE } else { usize::MAX };
        if let Some(found) = self.at_once(&from, patience) {
            return Ok((found, 1));
        }
        if let Some(advice) = self.refused() {
            return Err(self.failure(Some(advice)));
        }
        if self.log.iterations.len() >= self.options.iterations || !steps_allowed {
            return Err(self.failure(None));
        }
        let step = self.first_step();
        if FAR_BEYOND.contains(&step) {
            return self.glance(step);
        }
        if scouted && self.log.indefinite() >= PATIENCE {
            self.outlook.refuse(1.0);
            match self.scout(step) {
                Err(None) => {}
                found => return found.map_err(|advice| self.failure(advice)),
            }
            if let Some(found) = self.at_once(&from, usize::MAX) {
                return Ok((found, 1));
            }
        }
        let before = self.log.iterations.len();
        if let Some(found) = self.by_softer_volume() {
            return Ok(found);
        }
        // The detour leaves the load increments their iterations.
        self.options.iterations += self.log.iterations.len() - before;
        self.by_steps(step, None)
    }

    /// Whether a balance without a potential, at rest, moves too far for an attempt at the whole load.
    fn rolls_up(&mut self, from: &Unknowns) -> bool {
        let balance = !self.system.body.has_potential() && *from == self.system.rest();
        balance && self.first_step() < FIRST_GRADIENT / FAR
    }

    /// The equilibrium under the whole load, near to a state.
    fn at_once(&mut self, from: &Unknowns, patience: usize) -> Option<Equilibrium> {
        let (start, accuracy) = (Point::at_end(from.clone()), self.accuracy());
        let goal = Goal { line: &self.line, plane: None, accuracy, most_indefinite: patience };
        self.system.equilibrium(start, goal, &self.options, &mut self.log)
    }

    /// Some load steps, which may meet a limit point.
    fn scout(&mut self, step: f64) -> Result<(Equilibrium, usize), Option<Advice>> {
        let all = self.options.iterations;
        self.options.iterations = all.min(self.log.iterations.len() + SCOUT);
        self.release_stresses();
        let found = self.steps(step);
        self.options.iterations = all;
        found
    }

    /// The equilibrium by load steps from where the path has come to; advice where no other is known.
    fn by_steps(&mut self, step: f64, advice: Option<Advice>) -> Result<(Equilibrium, usize)> {
        self.release_stresses();
        // After some steps the next are as long as the last allow.
        let step = if self.points.len() > 1 { 1.0 } else { step };
        self.steps(step).map_err(|known| self.failure(known.or(advice)))
    }

    /// Finds the part that the body bears of a load far beyond its limit.
    fn glance(&mut self, step: f64) -> Result<(Equilibrium, usize)> {
        let [all, more] = GLANCE;
        let most = all.max(self.log.iterations.len() + more);
        self.options.iterations = most.min(self.options.iterations);
        self.by_steps(step, Some(Advice::FarBeyond { times: 1.0 / step }))
    }

    /// The body with a softer volumetric energy, if its law has one and the body a potential.
    fn softer_volume(&self) -> Option<Body> {
        self.system.body.has_potential().then(|| self.system.body.with_softer_volume(SOFTER))?
    }

    /// The equilibrium under the whole load from that of the body with a hundredth of the bulk modulus, and the number of solves and load
    /// steps. A large bulk modulus shortens Newton steps from rest, but not those from the equilibrium of a softer body. This is found
    /// at once, or by load steps, longer than those of the stiff body, in at most half of all iterations.
    fn by_softer_volume(&mut self) -> Option<(Equilibrium, usize)> {
        let body = self.softer_volume()?;
        let mut system = self.system.like(&body).ok()?;
        let (rest, all) = (system.rest(), self.options.iterations);
        let mut path = Path::from_rest(&mut system, self.line.clone(), &self.options);
        path.log = std::mem::take(&mut self.log);
        let mut softer = path.at_once(&rest, usize::MAX).map(|found| (found, 1));
        if softer.is_none() {
            path.options.iterations = all.min(path.log.iterations.len() + all / DETOUR);
            path.release_stresses();
            let step = path.first_step();
            softer = path.steps(step).ok();
        }
        self.log = path.log;
        let (found, steps) = softer?;
        Some((self.at_once(&found.unknowns, usize::MAX)?, 1 + steps))
    }
}
