//! Following an equilibrium by the volume that its pressure sweeps, through limit points.

use super::newton::Equilibrium;
use super::state::Unknowns;
use super::{BalanceSolution, BalanceSolver};
use crate::vector::dot;
use crate::watch::Log;
use crate::{Options, SolveError};
use sinew_energy::{Magnitude, PressureLoad, PressureSurface};
use std::time::Instant;

/// Iterations of one step; beyond, smaller steps are cheaper.
const MOST_ITERATIONS: usize = 20;
/// Unbalanced forces \[relative to loads and reactions\] and volumes of an equilibrium.
const TOLERANCE: f64 = 1e-10;
/// A residual that stops falling below this is at its floor.
const STALLED: f64 = 1e-7;

/// An equilibrium on a path of growing volume.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeStep {
    /// Volume that the loaded surface has swept along the pressure \[length³\].
    pub swept: f64,
    /// The equilibrium; its load factor is what the volume takes.
    pub solution: BalanceSolution,
}

/// Equilibria in the order of the volumes asked for.
pub type VolumeTrace = Vec<VolumeStep>;

/// The surface whose volume is prescribed.
enum Controlled {
    Flat(PressureLoad),
    Curved(PressureSurface),
}

impl Controlled {
    /// Swept volume; its gradient is written to `gradient`.
    fn swept(&self, displacement: &[f64], gradient: &mut [f64]) -> f64 {
        gradient.fill(0.0);
        let against = match self {
            Self::Flat(load) => load.value_and_add_gradient(displacement, &[], gradient),
            Self::Curved(load) => load.value_and_add_gradient(displacement, &[], gradient),
        };
        gradient.iter_mut().for_each(|g| *g = -*g);
        -against
    }
}

impl BalanceSolver<'_> {
    /// Equilibria at which the first pressure's surface has swept the given volumes \[length³\] one after the
    /// other; all loads are scaled by one unknown factor. Passes limit points, where the load that a body
    /// bears has a maximum.
    ///
    /// # Errors
    /// θ that makes no sense, no pressure with a potential, prescribed motions that are not zero, or
    /// [`SolveError::NotConverged`] with the last equilibrium.
    pub fn trace_volume(
        &mut self,
        theta: &[f64],
        volumes: &[f64],
        options: &Options,
    ) -> Result<VolumeTrace, SolveError> {
        self.system.body.check_theta(theta)?;
        let controlled = self.controlled()?;
        if volumes.iter().any(|volume| !volume.is_finite()) {
            return Err(SolveError::VolumeControl { problem: "a volume asked for is not finite" });
        }
        let mut trace: VolumeTrace = Vec::with_capacity(volumes.len());
        let mut reached = Point { swept: 0.0, load_factor: 0.0, unknowns: self.rest() };
        let mut before: Option<Point> = None;
        for &target in volumes {
            let start = Instant::now();
            let mut history = Log::default();
            let mut step = target - reached.swept;
            let mut steps = 0;
            while reached.swept != target {
                let goal = if (target - reached.swept).abs() <= step.abs() * (1.0 + 1e-9) {
                    target
                } else {
                    reached.swept + step
                };
                let guess = reached.extrapolated(before.as_ref(), goal);
                let found = self.at_volume(&controlled, guess, theta, options, &mut history);
                let Some((load_factor, found)) = found else {
                    step *= 0.5;
                    if step.abs() < options.least_load_step * (target - reached.swept).abs()
                        || history.iterations.len() >= options.iterations
                    {
                        let worst_cells = self.system.worst_cells();
                        let displacement = reached.unknowns.displacement;
                        return Err(history.failure(
                            reached.load_factor,
                            displacement,
                            worst_cells,
                        ));
                    }
                    continue;
                };
                steps += 1;
                let next = Point { swept: goal, load_factor, unknowns: found.unknowns.clone() };
                before = Some(std::mem::replace(&mut reached, next));
                if goal == target {
                    let mut solution = self.solution(found, theta, load_factor);
                    (solution.load_steps, solution.history) = (steps, history.take());
                    solution.seconds = start.elapsed().as_secs_f64();
                    trace.push(VolumeStep { swept: target, solution });
                }
            }
        }
        Ok(trace)
    }

    fn controlled(&self) -> Result<Controlled, SolveError> {
        let potential = &self.system.body.body;
        if potential.prescribed.iter().flatten().any(|&u| u != 0.0) {
            return Err(SolveError::VolumeControl { problem: "supports prescribe a motion" });
        }
        let magnitude = Magnitude::Fixed(1.0);
        let flat = potential.pressures.first().cloned();
        let curved = potential.surfaces.first().cloned();
        match (flat, curved) {
            (Some(load), _) => Ok(Controlled::Flat(PressureLoad { magnitude, ..load })),
            (_, Some(load)) => Ok(Controlled::Curved(PressureSurface { magnitude, ..load })),
            _ => Err(SolveError::VolumeControl {
                problem: "no pressure acts on a surface whose rim is held",
            }),
        }
    }

    /// Newton's method on the balance and the swept volume, for the unknowns and the load factor.
    fn at_volume(
        &mut self,
        controlled: &Controlled,
        guess: Point,
        theta: &[f64],
        options: &Options,
        history: &mut Log<'_>,
    ) -> Option<(f64, Equilibrium)> {
        let Point { swept: goal, mut load_factor, unknowns: mut at } = guess;
        let mut slope = vec![0.0; at.displacement.len()];
        let (mut before, mut linear_iterations) = (f64::INFINITY, 0);
        let mut negative_pivots = 0;
        for iteration in 0..MOST_ITERATIONS {
            if history.iterations.len() >= options.iterations {
                return None;
            }
            let residual = self.system.assemble(&at, theta, load_factor, None);
            let gap = goal - controlled.swept(&at.displacement, &mut slope);
            self.record(&at, load_factor, &residual, history);
            let size = self.system.size(&residual)?.max(gap.abs() / self.system.volume());
            let stalled = size <= STALLED && size > 0.5 * before;
            if iteration > 0 && (size <= TOLERANCE || stalled) {
                let found =
                    Equilibrium { unknowns: at, residual, negative_pivots, linear_iterations };
                return Some((load_factor, found));
            }
            before = size;
            let preconditioner = self.precondition().ok()?;
            negative_pivots = preconditioner.negative_pivots;
            let loads = self.system.load_derivative(&at.displacement, theta);
            let minus = |values: &[f64]| values.iter().map(|v| -v).collect::<Vec<_>>();
            let (own, first) = self.solve_linear(&preconditioner, &minus(&residual.values));
            let (by_load, second) = self.solve_linear(&preconditioner, &minus(&loads));
            linear_iterations += first.iterations + second.iterations;
            let free: Vec<_> = self.system.sparsity.gather(&slope).collect();
            let along = dot(&free, &by_load[..free.len()]);
            let more = (gap - dot(&free, &own[..free.len()])) / along;
            if !more.is_finite() {
                return None;
            }
            let change: Vec<_> = own.iter().zip(&by_load).map(|(a, b)| a + more * b).collect();
            let length = self.take(&mut at, &change, theta)?;
            load_factor += length * more;
            let last = history.iterations.last_mut()?;
            (last.step, last.shift) = (length, preconditioner.shift);
        }
        None
    }
}

/// A point of the path.
#[derive(Clone)]
struct Point {
    swept: f64,
    load_factor: f64,
    unknowns: Unknowns,
}

impl Point {
    /// The point at another volume on the line through this one and the one before.
    fn extrapolated(&self, before: Option<&Self>, swept: f64) -> Self {
        let Some(earlier) = before else { return Self { swept, ..self.clone() } };
        let ratio = (swept - self.swept) / (self.swept - earlier.swept);
        let line = |now: f64, then: f64| now + ratio * (now - then);
        let lines =
            |now: &[f64], then: &[f64]| now.iter().zip(then).map(|(&u, &v)| line(u, v)).collect();
        let [now, then] = [&self.unknowns, &earlier.unknowns];
        let unknowns = Unknowns {
            displacement: lines(&now.displacement, &then.displacement),
            pressure: lines(&now.pressure, &then.pressure),
        };
        Self { swept, load_factor: line(self.load_factor, earlier.load_factor), unknowns }
    }
}
