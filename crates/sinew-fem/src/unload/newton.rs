//! Newton's method on the positions at rest, and load steps where it fails.

use super::lu::Entries;
use crate::CellValue;
use crate::elements::place;
use crate::linear::{difference, gmres, norm};
use crate::unload::state::{Level, Trial, UnloadOptions, volume_ratios};
use crate::unload::{Image, Result, Unload, UnloadError};

/// Unbalanced forces \[relative to loads and reactions\] that are at their floor.
const BALANCED: f64 = 1e-14;
/// Unbalanced forces where they no longer fall: rounding errors of large bodies.
const STALLED: f64 = 1e-9;
/// A step that leaves more than this part of the forces no longer falls.
const FALLING: f64 = 0.5;
/// Least part of its volume that a step lets a cell keep.
const LEAST_SHRINK: f64 = 0.1;
/// Largest growth of the residual over its minimum, relative to loads and reactions and absolute, and the number of
/// successive steps above it. Bending stretches a slender body and raises the reactions too; an exponential law
/// overshoots by orders of magnitude.
const MOST_GROWTH: [f64; 2] = [6.0, 100.0];
const MOST_RISES: usize = 8;
/// Most halvings of a step.
const MOST_HALVINGS: i32 = 8;
/// Bounds of the relative residual of linear systems, and its ratio to the unbalanced forces: Newton's method stays
/// quadratic.
const LINEAR: [f64; 2] = [1e-12, 1e-4];
const FORCING: f64 = 1e-2;
/// Residual that is a solution where rounding errors leave no less.
const ROUGH: f64 = 1e-8;
/// Iterations of a linear system that cost about as much as another factor.
const MOST_LINEAR: usize = 12;
/// Unbalanced forces \[relative to loads and reactions\] below which the factor of another state preconditions.
const NEAR: f64 = 3e-2;
/// First load step [part of the load], and factors of a step after a failure and after a success.
const FIRST_STEP: f64 = 0.25;
const CUT: f64 = 0.4;
const GROWTH: f64 = 1.6;
/// Load step below which the search gives up [part of the load], and most iterations at one load.
const LEAST_STEP: f64 = 1e-3;
const MOST_ITERATIONS: usize = 25;

impl Unload<'_> {
    /// The trial under a load that rises from zero, where the image is the body at rest.
    pub(super) fn step_by_step(
        &mut self,
        theta: &[f64],
        options: &UnloadOptions,
        iterations: &mut usize,
    ) -> Result<(Trial, usize)> {
        let stressing = self.image.system.stressing_entries(theta);
        let level = |factor: f64| {
            let mut theta = theta.to_vec();
            stressing.iter().for_each(|&entry| theta[entry] *= factor);
            Level { factor, theta }
        };
        let rest = vec![0.0; self.image.system.body.prescribed.len()];
        let mut points = vec![(0.0, rest)];
        let (mut step, mut load_steps) = (FIRST_STEP, 0);
        loop {
            let (reached, _) = points[points.len() - 1];
            let factor = if reached + step >= 1.0 - 1e-9 { 1.0 } else { reached + step };
            let guess = extrapolated(&points, factor);
            match self.newton(guess, &level(factor), options, iterations) {
                Some(trial) => {
                    load_steps += 1;
                    if factor == 1.0 {
                        return Ok((trial, load_steps));
                    }
                    points.push((factor, trial.motion));
                    step *= GROWTH;
                }
                None => step *= CUT,
            }
            if step < LEAST_STEP || *iterations >= options.iterations {
                return Err(self.image.not_found(&points, *iterations));
            }
        }
    }

    /// The trial that is balanced at one load; `None` when there is no progress.
    ///
    /// A linear step that bends a slender body stretches it, so forces may rise as long as they fall soon after.
    pub(super) fn newton(
        &mut self,
        start: Vec<f64>,
        level: &Level,
        options: &UnloadOptions,
        iterations: &mut usize,
    ) -> Option<Trial> {
        let mut trial = Trial::new(&self.image, start, level)?;
        let (mut lowest, mut rises) = ([f64::INFINITY; 2], 0);
        for _ in 0..MOST_ITERATIONS {
            let gap = self.image.gap(&trial.motion, level.factor);
            let size = trial.size();
            if gap.is_none() && size <= BALANCED.max(options.accuracy) {
                return Some(trial);
            }
            if *iterations >= options.iterations || rises > MOST_RISES {
                return None;
            }
            *iterations += 1;
            let step = self.step(&trial, level, gap.as_deref())?;
            if gap.is_none() {
                lowest = [size.min(lowest[0]), trial.force.min(lowest[1])];
            }
            let most = std::array::from_fn(|i| MOST_GROWTH[i] * lowest[i]);
            let next = self.image.along(&trial, &step, level, most);
            if gap.is_none() && size <= STALLED {
                // At the floor of rounding errors: whichever is closer to balance.
                match next {
                    Some(next) if next.force <= FALLING * trial.force => trial = next,
                    Some(next) if next.force < trial.force => return Some(next),
                    _ => return Some(trial),
                }
                continue;
            }
            trial = next?;
            rises = if trial.size() < lowest[0] { 0 } else { rises + 1 };
        }
        None
    }

    /// Newton's step from a trial, `gap` to the supports included \[length\]. Near to balance the last factor preconditions.
    fn step(&mut self, trial: &Trial, level: &Level, gap: Option<&[f64]>) -> Option<Vec<f64>> {
        let tangent = self.image.tangent(trial.at(), level, gap)?;
        let sparsity = &self.image.system.sparsity;
        let by_motion = sparsity.gather(&tangent.by_motion);
        let right: Vec<f64> = trial.residual.iter().zip(by_motion).map(|(r, k)| -r - k).collect();
        let accuracy = (FORCING * trial.size()).clamp(LINEAR[0], LINEAR[1]);
        let near = trial.size() <= NEAR && gap.is_none() && self.factor.is_ready();
        let mut change = near.then(|| self.linear(&tangent.entries, &right, accuracy)).flatten();
        if change.is_none() {
            if !self.factor.factorise(sparsity, &tangent.entries) {
                return None;
            }
            change = self.linear(&tangent.entries, &right, accuracy);
        }
        let mut step = gap.map_or_else(|| vec![0.0; trial.motion.len()], <[f64]>::to_vec);
        self.image.system.sparsity.scatter(change?, &mut step);
        step.iter().all(|s| s.is_finite()).then_some(step)
    }

    /// Solves a linear system by GMRES that the last factor preconditions; `None` where that takes too many iterations.
    pub(super) fn linear(
        &self,
        entries: &Entries,
        right: &[f64],
        accuracy: f64,
    ) -> Option<Vec<f64>> {
        let sparsity = &self.image.system.sparsity;
        let mut change = vec![0.0; right.len()];
        let apply = |from: &[f64], to: &mut [f64]| entries.multiply(sparsity, from, to);
        let precondition = |from: &[f64], to: &mut [f64]| {
            to.copy_from_slice(from);
            self.factor.solve(to);
        };
        let outcome = gmres(apply, precondition, right, &mut change, accuracy, MOST_LINEAR);
        // Rounding errors of a stiffness of bad condition may end it early. Written so that a NaN is no solution.
        let solved = outcome.relative_residual <= accuracy.max(ROUGH);
        solved.then_some(change)
    }
}

impl Image<'_> {
    /// The motion that supports still have to make, if anything.
    fn gap(&self, motion: &[f64], factor: f64) -> Option<Vec<f64>> {
        let mut there = motion.to_vec();
        place(self.system.body, -factor, &mut there);
        let gap = difference(&there, motion);
        (norm(&gap) > 0.0).then_some(gap)
    }

    /// The longest of the steps 1, ½, ¼, … that keeps the volume of all cells and bounds the residual, relative and
    /// absolute.
    fn along(&self, from: &Trial, step: &[f64], level: &Level, most: [f64; 2]) -> Option<Trial> {
        let lengths = (0..=MOST_HALVINGS).map(|k| 0.5f64.powi(k));
        let found = lengths.map(|length| {
            let motion = from.motion.iter().zip(step).map(|(w, s)| w + length * s).collect();
            let next = Trial::new(self, motion, level)?;
            let sound = next.least >= LEAST_SHRINK * from.least;
            (sound && next.size() <= most[0] && next.force <= most[1]).then_some(next)
        });
        found.flatten().next()
    }

    fn not_found(&self, points: &[(f64, Vec<f64>)], iterations: usize) -> UnloadError {
        let (part, motion) = &points[points.len() - 1];
        let nothing = CellValue { cell: 0, value: f64::NAN };
        let ratios = self.moved(motion).map(|rest| volume_ratios(self.system.body, &rest));
        let [least, largest] = ratios.unwrap_or([nothing; 2]);
        UnloadError::NotFound { part: *part, iterations, least, largest }
    }
}

/// The line through the last two points.
fn extrapolated(points: &[(f64, Vec<f64>)], to: f64) -> Vec<f64> {
    match points {
        [.., (a, first), (b, second)] => {
            let way = (to - b) / (b - a);
            first.iter().zip(second).map(|(u, v)| v + way * (v - u)).collect()
        }
        [(_, only)] => only.clone(),
        [] => Vec::new(),
    }
}
