//! Many θ of one body: in nearest-neighbour order, or along a path.

use crate::{LoadSteps, Options, Progress, Result, Solution, SolveError, Solver, Stop};
use rayon::prelude::*;
use sinew_energy::Body;
use sinew_mesh::extents;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Samples that are solved one after the other, each from its predecessor. The partition depends on nothing
/// else, so results do not depend on the number of threads.
pub const CHAIN: usize = 25;

/// Difference step \[relative to the change of θ\] of the forces: exact for laws linear in θ, small enough for the
/// others, and ten times cheaper than [`Solver::sensitivity`], as only a guess is needed.
const DIFFERENCE: f64 = 1e-2;

/// Quasi-Newton steps with the predecessor's stiffness before Newton's method, and the relative residual that ends
/// them. Beams take 2.3 factorisations instead of 3.8, ventricles 3.5 instead of 5.5, in a quarter less time. Twice as
/// many steps gain no more.
const STEPS: usize = 8;
const ENOUGH: f64 = 1e-6;

/// Equilibria for many θ, in parallel: a result for each, in the order they were given.
///
/// The samples are put in nearest-neighbour order (in the logarithm of positive entries) and cut into chains; within
/// a chain each solve starts from its predecessor's solution, moved along its derivative in θ and by some steps with its stiffness. Results are
/// the same for any number of threads. `progress` is called after each sample.
///
/// [`Solution::jumped`] marks solutions whose search met an indefinite stiffness, and those that began at such a solution: neighbouring
/// samples may be on different branches of stable equilibria. Check them by [`Solver::under_rising_load`].
///
/// # Errors
/// A body that cannot be solved for any θ, see [`Solver::new`]; failures of single samples are in the results.
#[doc(alias = "parameter study")]
pub fn sweep(
    body: &Body,
    thetas: &[Vec<f64>],
    options: &Options,
    progress: impl Fn() + Sync,
) -> Result<Vec<Result<Solution>>> {
    let found = Mutex::new(Vec::with_capacity(thetas.len()));
    let each = |index, result| {
        found.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
        progress();
        ControlFlow::Continue(())
    };
    resume_sweep(body, thetas, &[], options, each, |_| ())?;
    let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    found.sort_by_key(|&(index, _)| index);
    Ok(found.into_iter().map(|(_, result)| result).collect())
}

/// Earlier result of a sample, from a sweep that was stopped.
#[derive(Clone, Debug, PartialEq)]
pub enum Earlier {
    /// Displacement of its equilibrium, node by node \[length\].
    Solved(Vec<f64>),
    /// There was no equilibrium.
    Failed,
}

/// [`sweep`] that can be stopped and resumed. Samples in `earlier`, by index, are left out. Chains start again from them, so that the
/// other results agree with an uninterrupted sweep to the solver's rounding, and to the bit without earlier ones.
///
/// `each` receives every result with its index, on the thread that found it; a break ends all chains after the current solves. `watch` receives
/// each state that a solve comes to, for progress within solves that take long.
///
/// # Errors
/// A body that cannot be solved for any θ, see [`Solver::new`].
pub fn resume_sweep(
    body: &Body,
    thetas: &[Vec<f64>],
    earlier: &[Option<Earlier>],
    options: &Options,
    each: impl Fn(usize, Result<Solution>) -> ControlFlow<()> + Sync,
    watch: impl Fn(&Progress<'_>) + Sync,
) -> Result<()> {
    let solver = Solver { watch: Some(&watch), ..Solver::new(body)? };
    let (path, stopped) = (neighbours(thetas), AtomicBool::new(false));
    let solve_chain = |chain: &[usize]| -> Result<()> {
        let (mut solver, mut last, mut before) = (solver.fresh()?, None::<Solution>, None);
        for &index in chain {
            if let Some(Some(known)) = earlier.get(index) {
                (last, before) = (None, Some((index, known)));
                continue;
            }
            if stopped.load(Ordering::Relaxed) {
                break;
            }
            if let Some((index, Earlier::Solved(displacement))) = before.take() {
                // Its factor is needed again.
                last = solver.solve_from(displacement, &thetas[index], options).ok();
            }
            let result = match &last {
                Some(near) => solver.solve_neighbour(near, &thetas[index], options).map(|found| {
                    // On whichever branch its neighbour is.
                    Solution { jumped: found.jumped || near.jumped, ..found }
                }),
                None => solver.solve(&thetas[index], options),
            };
            last = result.as_ref().ok().cloned();
            if each(index, result).is_break() {
                stopped.store(true, Ordering::Relaxed);
            }
        }
        Ok(())
    };
    path.par_chunks(CHAIN).try_for_each(solve_chain)
}

impl Solver<'_> {
    /// The equilibrium for θ from the one this solver found last, moved along its derivative in θ.
    fn solve_neighbour(
        &mut self,
        near: &Solution,
        theta: &[f64],
        options: &Options,
    ) -> Result<Solution> {
        if !near.has_potential {
            return self.solve_near(near, theta, options);
        }
        self.body().check_theta(theta)?;
        let Solution { displacement, theta: from, .. } = near;
        if !near.is_stable() || options.load_steps == LoadSteps::Always {
            return self.solve_from(displacement, theta, options);
        }
        let along: Vec<_> = from.iter().zip(theta).map(|(&a, &b)| tangent_step(a, b)).collect();
        let gradient_at = |sign: f64| {
            let moved = from.iter().zip(&along).map(|(t, d)| t + sign * DIFFERENCE * d);
            let moved: Vec<_> = moved.collect();
            let mut gradient = vec![0.0; displacement.len()];
            self.body().value_and_gradient(displacement, &moved, &mut gradient);
            gradient
        };
        let (up, down) = (gradient_at(1.0), gradient_at(-1.0));
        let quotient = |(u, d): (&f64, &f64)| (u - d) / (2.0 * DIFFERENCE);
        let forces: Vec<_> = up.iter().zip(&down).map(quotient).collect();
        // The last factor belongs to the iterate before the last: near enough for a guess.
        let mut guess = displacement.clone();
        self.system.add_newton_step(&forces, &mut guess);
        if !guess.iter().all(|u| u.is_finite()) {
            guess.clone_from(displacement);
        }
        let stop = Stop { residual: ENOUGH, ..Stop::after(STEPS) };
        if let Ok(refined) = self.refine(&guess, theta, stop) {
            guess = refined.displacement;
        }
        self.solve_from(&guess, theta, options)
    }
}

/// Change from `a` to `b` to first order in the logarithm of positive numbers.
fn tangent_step(a: f64, b: f64) -> f64 {
    if a > 0.0 && b > 0.0 { a * (b / a).ln() } else { b - a }
}

/// Nearest-neighbour order of parameter sets, from the first one; distances are in the logarithms of positive entries.
pub fn neighbours(thetas: &[Vec<f64>]) -> Vec<usize> {
    let points = log_coordinates(thetas);
    let mut left: Vec<_> = (0..points.len()).collect();
    let mut path = Vec::with_capacity(points.len());
    let mut current = 0;
    loop {
        let distance = |&index: &usize| -> f64 {
            points[current].iter().zip(&points[index]).map(|(a, b)| (a - b) * (a - b)).sum()
        };
        let distances = left.iter().map(distance).enumerate();
        // The first of equals.
        let Some((place, _)) = distances.min_by(|a, b| a.1.total_cmp(&b.1)) else { return path };
        current = left.remove(place);
        path.push(current);
    }
}

/// Entries of θ as coordinates: the logarithm where a column is positive, scaled to [0, 1].
fn log_coordinates(thetas: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let width = thetas.iter().map(Vec::len).max().unwrap_or(0);
    let mut coordinates = vec![vec![0.0; width]; thetas.len()];
    for column in 0..width {
        let entry = |row: &Vec<f64>| row.get(column).copied().unwrap_or(f64::NAN);
        let positive = thetas.iter().all(|row| entry(row) > 0.0);
        let value = |row: &Vec<f64>| if positive { entry(row).ln() } else { entry(row) };
        let finite = || thetas.iter().map(value).filter(|x| x.is_finite());
        let least = finite().fold(f64::INFINITY, f64::min);
        let most = finite().fold(f64::NEG_INFINITY, f64::max);
        let range = if most > least { most - least } else { 1.0 };
        for (row, theta) in coordinates.iter_mut().zip(thetas) {
            let x = (value(theta) - least) / range;
            // Samples without a sensible value are refused later; they need a place until then.
            row[column] = if x.is_finite() { x } else { 0.0 };
        }
    }
    coordinates
}

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
    /// once, the way to it is halved; the path ends where no such step remains on its branch. `progress` is called after each, and ends the
    /// path there by a break.
    ///
    /// ```
    /// use sinew_energy::{Load, Magnitude, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_fem::{Options, Solver};
    /// use sinew_mesh::TruncatedEllipsoid;
    /// use std::ops::ControlFlow;
    ///
    /// let body = Scene::new(TruncatedEllipsoid::LAND.wall([1, 16, 8]).tetrahedra(), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 1.0..=10.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 1.0..=10.0))
    ///     .parameter(Parameter::linear("p", "kPa", 0.0..=2.0))
    ///     .load(Load::Pressure { facets: "endo".into(), magnitude: Magnitude::Theta(2) })
    ///     .support(Support::clamped("base"))
    ///     .lower()?;
    /// let thetas: Vec<_> = (0..=4).map(|frame| vec![5.0, 8.0, 0.2 * f64::from(frame)]).collect();
    /// let trace = Solver::new(&body)?.trace(&thetas, &Options::default(), || ControlFlow::Continue(()))?;
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
        mut progress: impl FnMut() -> ControlFlow<()>,
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
        let mut under_way = progress();
        if let [from, to, ..] = thetas {
            // Where even this is not found, the way is halved further.
            let probe = between(from, to, PROBE);
            if let Ok(found) = follower.solver.solve_near(&follower.last, &probe, &near) {
                follower.rate = follower.moved(&found) / PROBE;
            }
        }
        for pair in thetas.windows(2) {
            if under_way.is_break() {
                break;
            }
            if let Err(end) = follower.advance([&pair[0], &pair[1]], 1.0, MOST_HALVINGS) {
                return Ok(Trace { solutions, end: Some(end) });
            }
            solutions.push(follower.last.clone());
            under_way = progress();
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
