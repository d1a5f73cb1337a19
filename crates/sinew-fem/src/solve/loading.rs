//! Solving under the whole load: at once if possible, else by load increments, unless the load is beyond a limit point.
//! Nearly incompressible bodies are also reached through one with a smaller bulk modulus.

use crate::elements::Unknowns;
use crate::linear::{difference, norm};
use crate::solve::{Equilibrium, FIRST_GRADIENT, FIRST_STEP, Goal, Path, Point, Progress};
use crate::{Advice, Line, LoadSteps, Options, Result, Solution, Solver};
use sinew_energy::Body;
use std::ops::Range;
use std::time::Instant;

/// Largest difference of two displacements of the same equilibrium [relative to their norm]: rounding errors, amplified
/// by an ill-conditioned stiffness.
const SAME: f64 = 1e-4;
/// Residuals that tell branches apart, on the way and at the end; to rounding errors a path takes twice the time.
const ON_THE_WAY: f64 = 1e-3;
const AT_THE_END: f64 = 1e-8;

impl Solver<'_> {
    /// The equilibrium for θ, starting from the reference configuration.
    ///
    /// # Errors
    /// θ that makes no sense, or [`SolveError::NotConverged`](crate::SolveError::NotConverged).
    #[doc(alias("Newton-Raphson", "line search"))]
    pub fn solve(&mut self, theta: &[f64], options: &Options) -> Result<Solution> {
        let rest = self.system.rest();
        self.solve_told(rest, theta, options, &mut |_| ())
    }

    /// The equilibrium for θ, starting from a displacement \[length\] that should be near it.
    ///
    /// When the search from there fails, loads and prescribed motions are raised step by step from rest. A field of pressure begins at zero; see
    /// [`Solver::solve_near`].
    ///
    /// # Errors
    /// As for [`Solver::solve`], and an initial displacement of the wrong length or that is not finite.
    pub fn solve_from(
        &mut self,
        initial: &[f64],
        theta: &[f64],
        options: &Options,
    ) -> Result<Solution> {
        let from = self.at(initial, theta)?;
        self.solve_told(from, theta, options, &mut |_| ())
    }

    /// The equilibrium for θ, starting from another one with its field of pressure; step by step from rest where that fails.
    ///
    /// # Errors
    /// As for [`Solver::solve`], and a solution of another body.
    pub fn solve_near(
        &mut self,
        near: &Solution,
        theta: &[f64],
        options: &Options,
    ) -> Result<Solution> {
        let from = self.checked(near, theta)?;
        self.solve_told(from, theta, options, &mut |_| ())
    }

    /// The equilibrium under loads and prescribed motions that rise slowly from rest, if it differs from `solution`. Of
    /// several stable equilibria, the whole load at once may find one that a rising load does not. A few points of a smooth curve from rest
    /// are enough; where it does not show, this costs a solve by load steps, to smaller accuracy. `watch` is called with each state that the iteration comes to.
    ///
    /// # Errors
    /// As for [`Solver::solve`], and a solution of another body.
    pub fn under_rising_load(
        &mut self,
        solution: &Solution,
        options: &Options,
        watch: &mut impl FnMut(&Progress<'_>),
    ) -> Result<Option<Solution>> {
        let end = self.checked(solution, &solution.theta)?;
        let mut options = Options { load_steps: LoadSteps::Always, ..*options };
        if self.body().has_potential() {
            let mut tell = |state: &Progress<'_>| watch(state);
            let line = Line::of_loads(&solution.theta);
            let mut path = Path::from_rest(&mut self.system, line, &options);
            path.log.watch = Some(&mut tell);
            if path.leads_to(end) {
                return Ok(None);
            }
            options.accuracy = ON_THE_WAY;
            options.minimum_accuracy = options.minimum_accuracy.max(AT_THE_END);
        }
        let risen = self.solve_watched(&solution.theta, &options, watch)?;
        let apart = norm(&difference(&risen.displacement, &solution.displacement));
        let size = norm(&risen.displacement).max(norm(&solution.displacement));
        Ok((apart > SAME * size).then_some(risen))
    }

    /// Solves as [`Solver::solve`] does; `watch` is called with each state that the iteration comes to.
    ///
    /// ```no_run
    /// # fn f(solver: &mut sinew_fem::Solver) -> Result<(), sinew_fem::SolveError> {
    /// use sinew_fem::{Options, Progress};
    /// let mut watch = |state: &Progress| eprintln!("{}", state.in_words());
    /// solver.solve_watched(&[75.0, 75.0], &Options::default(), &mut watch)?;
    /// # Ok(()) }
    /// ```
    ///
    /// # Errors
    /// As for [`Solver::solve`].
    pub fn solve_watched(
        &mut self,
        theta: &[f64],
        options: &Options,
        watch: &mut impl FnMut(&Progress<'_>),
    ) -> Result<Solution> {
        let rest = self.system.rest();
        self.solve_told(rest, theta, options, watch)
    }

    fn solve_told(
        &mut self,
        from: Unknowns,
        theta: &[f64],
        options: &Options,
        tell: &mut dyn FnMut(&Progress<'_>),
    ) -> Result<Solution> {
        let (start, watch) = (Instant::now(), self.watch);
        let mut tell = |state: &Progress<'_>| {
            watch.iter().for_each(|watch| watch(state));
            tell(state);
        };
        self.system.body.check_theta(theta)?;
        let mut path = Path::from_rest(&mut self.system, Line::of_loads(theta), options);
        path.log.watch = Some(&mut tell);
        let found = path.run(from)?;
        let (at, history) = (path.line.at(found.0.place), path.log.take());
        Ok(Solution::new(&self.system, found, at, history, start))
    }
}

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
