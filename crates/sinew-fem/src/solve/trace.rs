//! Equilibria at a sequence of parameters, each from the one before, as under a rising load.

use crate::{LoadSteps, Options, Result, Solution, SolveError, Solver};
use sinew_mesh::extents;

/// Most halvings of the step between two θ before the path ends: its end is known to a thousandth of that step.
const MOST_HALVINGS: usize = 10;

/// Equilibria along a path, as far as it goes.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Equilibria up to the end of the path, in the order of the given parameters.
    pub solutions: Vec<Solution>,
    /// End of the path, if it was before the last θ.
    pub end: Option<TraceEnd>,
}

/// End of a path before the last θ: at a limit point, a bifurcation, or where nothing is found.
#[derive(Clone, Debug)]
pub struct TraceEnd {
    /// Last parameters with an equilibrium on the path.
    pub reached: Vec<f64>,
    /// Nearest parameters without an equilibrium on the path.
    pub beyond: Vec<f64>,
    /// Error of the solver there; `None` where it found an equilibrium on another branch only.
    pub error: Option<SolveError>,
}

/// Largest change of the displacement per change of θ, relative to that of the step before, that counts as the same branch. Towards a limit point
/// it grows as the inverse root of the distance: 2.4-fold from one step to the next of its length, 4-fold to one of an eighth.
const GROWTH: f64 = 4.0;

/// Change of the displacement from one θ to the next [relative to the longest edge of the box around the body] below which nothing has snapped.
const NO_SNAP: f64 = 1e-3;

/// Part of the first step over which the first rate is measured.
const PROBE: f64 = 1.0 / 64.0;

impl Solver<'_> {
    /// Equilibria at each of `thetas`, each found from the one before, the first under a load that rises from rest. Where the next is not found at
    /// once, the way to it is halved; the path ends where no such step remains on its branch. `progress` is called after each.
    ///
    /// ```
    /// use sinew_energy::{Load, Magnitude, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_fem::{Options, Solver};
    /// use sinew_mesh::TruncatedEllipsoid;
    ///
    /// let body = Scene::new(TruncatedEllipsoid::LAND.wall([1, 16, 8]).tetrahedra(), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0))
    ///     .parameter(Parameter::linear("p", "kPa", 0.0..=2.0))
    ///     .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(2) })
    ///     .support(Support::clamped("base"))
    ///     .lower()?;
    /// let thetas: Vec<_> = (0..=4).map(|frame| vec![5.0, 8.0, 0.2 * f64::from(frame)]).collect();
    /// let trace = Solver::new(&body)?.trace(&thetas, &Options::default(), || {})?;
    /// let volumes: Vec<f64> =
    ///     trace.solutions.iter().map(|s| body.cavity_volumes(&s.displacement)[0]).collect();
    /// assert!(trace.end.is_none() && volumes.is_sorted() && volumes[4] > 1.1 * volumes[0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// No θ, θ that makes no sense, or no equilibrium at the first one.
    pub fn trace(
        &mut self,
        thetas: &[Vec<f64>],
        options: &Options,
        mut progress: impl FnMut(),
    ) -> Result<Trace> {
        thetas.iter().try_for_each(|theta| self.system.body.check_theta(theta))?;
        let risen = Options { load_steps: LoadSteps::Always, ..*options };
        // Never from rest again.
        let iterations = options.iterations_per_load.min(options.iterations);
        let near = Options { load_steps: LoadSteps::WhenNeeded, iterations, ..*options };
        let least = NO_SNAP * extents(&self.system.body.positions).into_iter().fold(0.0, f64::max);
        let Some(first) = thetas.first() else {
            return Err(SolveError::Line { problem: "it has no point" });
        };
        let last = self.solve(first, &risen)?;
        let mut follower = Follower { solver: self, options: near, last, rate: least, least };
        let mut solutions = vec![follower.last.clone()];
        progress();
        if let [from, to, ..] = thetas {
            // Where even this is not found, the way is halved further.
            let probe = between(from, to, PROBE);
            if let Ok(found) = follower.solver.solve_near(&follower.last, &probe, &near) {
                follower.rate = follower.moved(&found) / PROBE;
            }
        }
        for pair in thetas.windows(2) {
            if let Err(end) = follower.advance([&pair[0], &pair[1]], 1.0, MOST_HALVINGS) {
                return Ok(Trace { solutions, end: Some(end) });
            }
            solutions.push(follower.last.clone());
            progress();
        }
        Ok(Trace { solutions, end: None })
    }
}

/// State of a trace.
struct Follower<'a, 'p> {
    solver: &'a mut Solver<'p>,
    options: Options,
    last: Solution,
    /// Largest change of a component of the displacement over the last step, per way from one θ to the next \[length\].
    rate: f64,
    /// Least rate for the test of the branch \[length\].
    least: f64,
}

impl Follower<'_, '_> {
    /// Largest change of a component of the displacement from the last equilibrium \[length\].
    fn moved(&self, to: &Solution) -> f64 {
        let [from, to] = [&self.last, to].map(|solution| &solution.displacement);
        from.iter().zip(to).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max)
    }

    /// Goes from one θ to another, `part` of a whole step.
    fn advance(
        &mut self,
        [from, to]: [&[f64]; 2],
        part: f64,
        halvings: usize,
    ) -> Result<(), TraceEnd> {
        let error = match self.solver.solve_near(&self.last, to, &self.options) {
            Ok(found) => {
                let rate = self.moved(&found) / part;
                let same_branch = !found.has_potential || !found.jumped && found.is_stable();
                if same_branch && rate <= GROWTH * self.rate.max(self.least) {
                    (self.last, self.rate) = (found, rate);
                    return Ok(());
                }
                None
            }
            Err(error) => Some(error),
        };
        if halvings == 0 {
            return Err(TraceEnd { reached: from.to_vec(), beyond: to.to_vec(), error });
        }
        let half = between(from, to, 0.5);
        self.advance([from, &half], 0.5 * part, halvings - 1)?;
        self.advance([&half, to], 0.5 * part, halvings - 1)
    }
}

fn between(from: &[f64], to: &[f64], part: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| a + part * (b - a)).collect()
}
