//! Newton's method on the positions at rest, load steps where it fails, and checks of what it found.

use super::lu::Entries;
use crate::elements::{Residual, State, System, Unknowns, place};
use crate::linear::{difference, dot, gmres, norm};
use crate::solve::{ON_THE_WAY, Path, Plane, Point};
use crate::unload::state::{Level, Loading, Trial, UnloadOptions, volume_ratios};
use crate::unload::{Image, Result, Unload, UnloadError};
use crate::{CellValue, Line, LoadSteps, Options, SolveError, Solver};
use sinew_energy::metrics::{displacement_error, mean_and_largest};
use sinew_mesh::{TriangleMesh, self_intersections};
use std::time::Instant;

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

/// Largest distance to the image after loading [relative to the largest displacement]: rounding errors, amplified by an
/// ill-conditioned stiffness.
const SAME: f64 = 1e-6;

impl Image<'_> {
    /// Checks a body at rest: that it does not cross itself, that the image is one of its stable equilibria, and that loading leads there.
    pub(super) fn judge(
        &self,
        trial: &Trial,
        theta: &[f64],
        options: &UnloadOptions,
    ) -> Result<Option<Loading>> {
        self.check_crossings(trial)?;
        let rest = &trial.rest;
        let mut system = self.system.like(rest)?;
        let residual = system.assemble(&Unknowns::of(&trial.displacement), theta, 1.0, None);
        let (shift, negative_pivots) = system.factorise(false).ok_or(SolveError::Singular)?;
        if negative_pivots > 0 {
            return Err(UnloadError::Unstable { negative_pivots });
        }
        let Some(forward) = &options.load else { return Ok(None) };
        let shown = connected(&mut system, trial, theta, forward, (residual, shift));
        if shown.is_some() {
            return Ok(shown);
        }
        let start = Instant::now();
        let load = |options: &Options| -> Result<_> {
            let mut solver = Solver::of(self.system.like(rest)?);
            let found = solver.solve(theta, options).map_err(UnloadError::NotLoaded)?;
            Ok((found.displacement, found.history.steps()))
        };
        let mut loaded = load(forward)?;
        let same = SAME * trial.motion.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
        let mut apart = farthest(&loaded.0, &trial.displacement);
        if apart.0 > same {
            let rising = Options { load_steps: LoadSteps::Always, ..*forward };
            loaded = load(&rising)?;
            apart = farthest(&loaded.0, &trial.displacement);
        }
        let (distance, node) = apart;
        if distance > same {
            return Err(UnloadError::OtherBranch { distance, node });
        }
        let seconds = start.elapsed().as_secs_f64();
        Ok(Some(Loading { distance, iterations: loaded.1, seconds }))
    }

    fn check_crossings(&self, trial: &Trial) -> Result<()> {
        let rest = &trial.rest.mesh;
        if rest.element().dimension != 3 {
            return Ok(());
        }
        let (surface, cells) = rest.boundary_surface();
        let found = self_intersections(&surface);
        if found.is_empty() {
            return Ok(());
        }
        let points = self.system.body.positions.clone();
        let before = self_intersections(&TriangleMesh { points, ..surface });
        let new: Vec<_> = found.iter().filter(|pair| !before.contains(pair)).collect();
        let Some(pair) = new.first() else { return Ok(()) };
        let cells = pair.map(|triangle| cells[triangle]);
        Err(UnloadError::CrossesItself { pairs: new.len(), cells })
    }
}

/// Largest distance of a node between two displacements \[length\], and the node.
fn farthest(first: &[f64], second: &[f64]) -> (f64, usize) {
    let distances = displacement_error(first, second).into_iter().zip(0..);
    distances.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0))
}

/// Largest distance to the image of its extrapolation from half-way \[relative to its displacement\]. Ventricles of the box have 0.06 to 0.13; those
/// beyond are loaded from rest.
const NEAR_IMAGE: f64 = 0.25;
/// Largest slope at an end of a monotone cubic \[relative to its secant\] (F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17, 1980).
const MONOTONE: f64 = 3.0;

/// The path to the image, whose stiffness was factorised last, with this shift and residual; `None` where doubt remains.
///
/// A state's place s on the path is the projection of its displacement u on that of the image, relative to the latter. The search for the equilibrium
/// at s = ½, whose load factor λ is unknown, starts on the parabola u(s) through rest and the image with the tangent there. This equilibrium
/// has to be stable, the parabola through rest and it, with its tangent, has to end near the image, and λ(s) has to be monotone.
fn connected(
    system: &mut System<'_>,
    trial: &Trial,
    theta: &[f64],
    options: &Options,
    (residual, shift): (Residual, f64),
) -> Option<Loading> {
    let start = Instant::now();
    let image: Vec<f64> = system.sparsity.gather(&trial.displacement).collect();
    let length = norm(&image);
    let moved_supports = system.body.prescribed.iter().flatten().any(|&u| u != 0.0);
    if moved_supports || length == 0.0 {
        return None;
    }
    let by_displacement: Vec<f64> = image.iter().map(|u| u / (length * length)).collect();
    // Change of the displacement with s, and of s with the load factor.
    let tangent = |by_load: &[f64]| -> (Vec<f64>, f64) {
        let rate = dot(&by_displacement, by_load);
        (by_load.iter().map(|u| u / rate).collect(), rate)
    };
    let mut path = Path::from_rest(system, Line::of_loads(theta), options);
    path.release_stresses();
    let state = State::whole(&trial.displacement, theta);
    let rate = path.system.rate_on(&path.line, state);
    let (correction, _) = path.system.solve(&residual.values, shift).ok()?;
    let (by_load, _) = path.system.solve(&rate, shift).ok()?;
    let (along, end) = tangent(&by_load);
    let parabola = image.iter().zip(&along).map(|(u, along)| 0.75 * u - 0.25 * along);
    let unknowns = Unknowns::of(&path.system.sparsity.scattered(parabola));
    let guess = Point { at: 0.5, place: 1.0 - 0.5 / end, unknowns, stress: None };
    let plane = Plane { normal: (by_displacement.clone(), 0.0), distance: 0.5 };
    let half = path.meeting(Some(&plane), guess, ON_THE_WAY)?;
    let (extrapolated, middle) = tangent(&half.by_place);
    let off = difference(&extrapolated, &image);
    let most = MONOTONE * 2.0;
    let monotone = 0.0 < middle
        && 1.0 <= most * half.place.min(1.0 - half.place) * middle
        && 1.0 <= most * (1.0 - half.place) * end;
    // Written so that a NaN leaves doubt.
    let near = norm(&off) <= NEAR_IMAGE * length;
    if half.negative_pivots > 0 || !monotone || !near {
        return None;
    }
    let [_, distance] = mean_and_largest(&path.system.sparsity.scattered(correction));
    let (iterations, seconds) = (path.log.iterations.len(), start.elapsed().as_secs_f64());
    Some(Loading { distance, iterations, seconds })
}
