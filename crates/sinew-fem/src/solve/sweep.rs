//! Many θ of one body, in nearest-neighbour order.

use crate::{LoadSteps, Options, Progress, Result, Solution, Solver, Stop};
use rayon::prelude::*;
use sinew_energy::Body;
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
            let moved: Vec<_> =
                from.iter().zip(&along).map(|(t, d)| t + sign * DIFFERENCE * d).collect();
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
    nearest_neighbour_path(&log_coordinates(thetas))
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

/// Starts at the first point and goes on to the nearest unvisited one, the first of equals.
fn nearest_neighbour_path(points: &[Vec<f64>]) -> Vec<usize> {
    let mut left: Vec<_> = (0..points.len()).collect();
    let mut path = Vec::with_capacity(points.len());
    let mut current = 0;
    loop {
        let distance = |&index: &usize| -> f64 {
            points[current].iter().zip(&points[index]).map(|(a, b)| (a - b) * (a - b)).sum()
        };
        let distances = left.iter().map(distance).enumerate();
        let Some((place, _)) = distances.min_by(|a, b| a.1.total_cmp(&b.1)) else { return path };
        current = left.remove(place);
        path.push(current);
    }
}
