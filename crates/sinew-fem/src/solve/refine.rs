//! Refinement of a displacement by quasi-Newton steps on the potential energy, without a factorisation.
//!
//! Limited-memory quasi-Newton steps (L-BFGS; J. Nocedal, Math. Comput. 35, 1980). The initial inverse is that of a stiffness
//! factorised once at a nearby state, scaled by the last step. A step costs a gradient and two
//! back-substitutions, a tenth or less of a Newton step.

use crate::elements::{System, check_potential, inadmissible, load_gradient, place};
use crate::linear::systems::CORRECTION;
use crate::linear::{add, difference, dot, norm, relative};
use crate::solve::{SUFFICIENT, flattens, minds_turned_cells};
use crate::{Result, SolveError, Solver};
use sinew_energy::metrics::mean_and_largest;
use sinew_energy::{Body, Frames};
use std::time::Instant;

/// Step pairs kept by the L-BFGS update; few steps are taken, so that more pairs would not help.
const MEMORY: usize = 10;
/// Backtracking factor, and the largest number of trials.
const SHORTER: f64 = 0.4;
const MOST_TRIALS: usize = 20;
/// Least relative change of the first step's length that a secant step makes: the frozen stiffness may have another
/// scale.
const OFF: f64 = 0.2;
/// Largest rescaling of the first step.
const LONGEST: f64 = 50.0;
/// Residual \[relative to loads and reactions\] of an equilibrium: rounding error of the forces.
const BALANCED: f64 = 1e-13;
/// Rounding errors of energies \[relative\].
const NOISE: f64 = 1e-14;
/// Contraction ratio of the steps that would follow, at least.
const CONTRACTS: f64 = 0.5;
/// Least ratio of an estimate to the one before that counts: a single one may be small by chance.
const LEAST: f64 = 0.5;
/// Steps that are required where none contracted at a neighbour, and steps whose largest ratio counts.
const SEEN: usize = 2;
/// Residual of the systems of quasi-Newton steps by conjugate gradients, relative to the forces: answers on 100 419 nodes take as many steps as with 0.01, and
/// two thirds of the time.
const INEXACT: f64 = 0.1;
/// Longest first step \[relative to the displacement\]: from farther off, small steps may end where a soft mode still misses much.
const FARTHEST: f64 = 0.1;
/// Safety factor on the series of steps that would follow: compliant modes contract more slowly than those that
/// dominate a step. The error was at most 0.57 of the bound in 17 000 answers on 20 slender bodies.
const SAFETY: f64 = 6.0;

/// Bounds of a refinement; the first that is met ends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Number of steps.
    pub steps: usize,
    /// Residual \[relative to loads and reactions where it began\].
    pub residual: f64,
    /// Estimated error: mean nodal distance to the equilibrium, relative to the mean nodal displacement; `None` estimates none.
    pub error: Option<f64>,
    /// Whether steps with the same stiffness contracted at a neighbouring θ. Then an accurate prediction is returned unchanged after one
    /// computed step, with an assumed contraction ratio of one half; [`Pairs`] of these steps, which would be dropped otherwise, update the stiffness.
    pub contracts: bool,
}

impl Stop {
    /// After so many steps, at equilibrium, or where no step lowers the energy.
    pub const fn after(steps: usize) -> Self {
        Self { steps, residual: BALANCED, error: None, contracts: false }
    }

    /// At an estimated error, or after so many steps; the state after the last one has no estimate.
    pub const fn within(error: f64, steps: usize) -> Self {
        Self { error: Some(error), ..Self::after(steps) }
    }
}

/// A displacement after quasi-Newton steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Refined {
    /// Displacement `[u_x, u_y, u_z]` node by node \[length\].
    pub displacement: Vec<f64>,
    /// Total potential energy \[stress·length³\].
    pub energy: f64,
    /// Norm of the unbalanced nodal forces where it began \[stress·length²\].
    pub residual_before: f64,
    /// Norm of the residual where it ended.
    pub residual_after: f64,
    /// Norm of loads and reactions where it ended \[stress·length²\].
    pub force_scale: f64,
    /// Estimated error as in [`Stop::error`], which bounds it; `None` where that was not reached.
    pub error: Option<f64>,
    /// Number of steps; fewer than allowed where no step lowers the energy, as at equilibrium.
    pub steps: usize,
    /// Wall-clock time \[s\].
    pub seconds: f64,
}

impl Refined {
    /// Final residual \[relative to loads and reactions\]. A value of about one is far from equilibrium, however much
    /// the residual fell. [`Solver::error_estimate`] gives the distance.
    pub fn unbalanced(&self) -> f64 {
        relative(self.residual_after, self.force_scale)
    }
}

impl Solver<'_> {
    /// Quasi-Newton steps at θ from a displacement \[length\] near to equilibrium, with the last factorised stiffness, until `stop`.
    /// Prescribed components are put in their places first.
    ///
    /// For an estimated error the next step is computed but not taken. Its length without the scale of the last step, or that of the frozen
    /// stiffness alone if it is longer, bounds the error with its contraction ratio, or that of the residual if it is larger (P. Deuflhard, Newton Methods for Nonlinear Problems, 2011,
    /// section 2.1). Use the stiffness of a neighbouring equilibrium, from [`Solver::error_estimate`] or [`Solver::solve`]. There is
    /// no estimate where the energy is above that of the body at rest.
    ///
    /// ```
    /// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_fem::{Options, Solver, Stop};
    /// let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
    ///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    ///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    ///     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
    ///     .support(Support::clamped("x_min"))
    ///     .lower()?;
    /// let mut solver = Solver::new(&beam)?;
    /// let near = solver.solve(&[55.0, 85.0], &Options::default())?.displacement;
    /// let found = solver.refine(&near, &[50.0, 90.0], Stop::within(1e-4, 8))?;
    /// assert!(found.error.is_some_and(|error| error <= 1e-4) && found.steps <= 4); // no factorisation
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, [`SolveError::Inadmissible`] where that inverts a cell,
    /// [`SolveError::Singular`] where nothing was factorised.
    #[doc(alias("L-BFGS", "quasi-Newton"))]
    pub fn refine(&self, from: &[f64], theta: &[f64], stop: Stop) -> Result<Refined> {
        self.refine_on(from, theta, stop, &mut Pairs::default())
    }

    /// [`Solver::refine`] with the curvature pairs of steps at a neighbouring θ with the same factor, and adds its own. They are dropped
    /// where [`Stop::contracts`] is false.
    ///
    /// ```
    /// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
    /// use sinew_fem::{Options, Pairs, Solver, Stop};
    /// # let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
    /// #     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
    /// #     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
    /// #     .load(Load::BodyForce([0.0, 0.0, -1e-2]))
    /// #     .support(Support::clamped("x_min"))
    /// #     .lower()?;
    /// let mut solver = Solver::new(&beam)?;
    /// let near = solver.solve(&[55.0, 85.0], &Options::default())?.displacement;
    /// let (mut pairs, stop) = (Pairs::default(), Stop::within(1e-4, 8));
    /// let found = solver.refine_on(&near, &[50.0, 90.0], stop, &mut pairs)?;
    /// let next = Stop { contracts: true, ..stop };
    /// let other = solver.refine_on(&found.displacement, &[51.0, 90.0], next, &mut pairs)?;
    /// assert!(other.error.is_some_and(|error| error <= 1e-4) && other.steps <= found.steps);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Solver::refine`].
    pub fn refine_on(
        &self,
        from: &[f64],
        theta: &[f64],
        stop: Stop,
        pairs: &mut Pairs,
    ) -> Result<Refined> {
        let body = self.body();
        self.system.refine(Potential { body, theta, frames: &body.frames }, from, stop, pairs)
    }
}

/// Potential that the steps lower, and the frames of its unknowns.
#[derive(Clone, Copy)]
pub(crate) struct Potential<'a> {
    pub body: &'a Body,
    pub theta: &'a [f64],
    pub frames: &'a Frames,
}

/// A state of a refinement, in free degrees of freedom.
struct At {
    displacement: Vec<f64>,
    energy: f64,
    /// Derivative of the energy.
    slope: Vec<f64>,
    /// Norm of the forces on supports.
    reactions: f64,
}

impl At {
    /// Norm of loads and reactions.
    fn force_scale(&self, Potential { body, theta, .. }: Potential<'_>) -> f64 {
        norm(&load_gradient(body, &self.displacement, theta)) + self.reactions
    }
}

impl System<'_> {
    /// Quasi-Newton steps with the last factor until `stop`.
    pub(crate) fn refine(
        &self,
        potential: Potential<'_>,
        from: &[f64],
        stop: Stop,
        Pairs(memory): &mut Pairs,
    ) -> Result<Refined> {
        let (start, Potential { body, theta, frames }) = (Instant::now(), potential);
        check_potential(body, from, theta)?;
        let mut first = from.to_vec();
        place(body, 1.0, &mut first);
        let mut at = self.at(first, potential);
        if !(at.energy.is_finite() && at.slope.iter().all(|g| g.is_finite())) {
            return Err(inadmissible(body, &at.displacement));
        }
        let (residual_before, force_scale) = (norm(&at.slope), at.force_scale(potential));
        if !stop.contracts {
            memory.0.clear();
        }
        let mut last = None::<(At, Vec<f64>)>;
        let (mut error, mut lengths, mut forces, mut steps) = (None, Vec::new(), Vec::new(), 0);
        loop {
            if norm(&at.slope) <= stop.residual * force_scale {
                error = stop.error.map(|_| 0.0);
                break;
            }
            if steps == stop.steps {
                break;
            }
            let mut solved = at.slope.clone();
            self.back_substitute(&mut solved, INEXACT);
            if let Some((from, before)) = last.take() {
                memory.0.extend(self.pair([&from, &at], [&before, &solved], frames));
                memory.0.drain(..memory.0.len().saturating_sub(MEMORY));
            }
            let first = steps == 0;
            let scale = memory.0.last().map_or(1.0, |pair| pair.scale);
            let direction = memory.applied(&at.slope, &solved, scale);
            if first && !direction.iter().all(|d| d.is_finite()) {
                return Err(SolveError::Singular);
            }
            if let Some(accuracy) = stop.error {
                let mean = |free: Vec<f64>| {
                    let mut step = vec![0.0; from.len()];
                    self.sparsity.scatter_along(frames, free, &mut step);
                    mean_and_largest(&step)[0]
                };
                let length = |solved: &[f64]| {
                    let [frozen, updated] = memory.estimates(&at.slope, solved).map(mean);
                    frozen.max(updated)
                };
                let [size, _] = mean_and_largest(&at.displacement);
                let seen = if stop.contracts { 0 } else { SEEN };
                forces.push(norm(&at.slope));
                let open = |lengths: &[f64]| left_open(lengths, &forces, seen) / size;
                lengths.push(length(&solved));
                if self.iterates && open(&lengths) <= accuracy {
                    // A truncated iteration shortens the step.
                    let mut precise = at.slope.clone();
                    self.back_substitute(&mut precise, CORRECTION);
                    lengths.pop();
                    lengths.push(length(&precise));
                }
                let open = open(&lengths);
                error = (open <= accuracy).then_some(open);
                if error.is_some() || (first && lengths[0] > FARTHEST * size) {
                    break;
                }
            }
            let Some(next) = self.step_along(&at, &direction, potential, first) else { break };
            last = Some((std::mem::replace(&mut at, next), solved));
            steps += 1;
        }
        let error = error.filter(|_| {
            let at_rest = energy_at_rest(body, theta);
            at_rest.is_none_or(|rest| at.energy <= rest + NOISE * at.energy.abs())
        });
        Ok(Refined {
            residual_before,
            residual_after: norm(&at.slope),
            force_scale: at.force_scale(potential),
            error,
            energy: at.energy,
            displacement: at.displacement,
            steps,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// Curvature pair of a step, where the stiffness is positive along it, from the slopes `solved` at both ends.
    fn pair(&self, [from, to]: [&At; 2], solved: [&[f64]; 2], frames: &Frames) -> Option<Pair> {
        let moved = difference(&to.displacement, &from.displacement);
        let step: Vec<f64> = self.sparsity.gather_along(frames, &moved).collect();
        let change = difference(&to.slope, &from.slope);
        let solved = difference(solved[1], solved[0]);
        let work = dot(&step, &change);
        let scale = work / dot(&change, &solved);
        let curved = work > 0.0 && scale > 0.0 && scale.is_finite();
        curved.then_some(Pair { step, change, solved, work, scale })
    }

    fn at(&self, displacement: Vec<f64>, potential: Potential<'_>) -> At {
        let Potential { body, theta, frames } = potential;
        let mut gradient = vec![0.0; displacement.len()];
        let energy = body.value_and_gradient(&displacement, theta, &mut gradient);
        let slope: Vec<f64> = self.sparsity.gather_along(frames, &gradient).collect();
        // Frames are orthonormal: without its free components the gradient is that of the supports.
        self.sparsity.scatter_along(frames, slope.iter().map(|g| -g), &mut gradient);
        At { displacement, energy, slope, reactions: norm(&gradient) }
    }

    /// Longest step along a direction, by backtracking, that meets the decrease condition.
    fn step_along(
        &self,
        at: &At,
        direction: &[f64],
        potential: Potential<'_>,
        first: bool,
    ) -> Option<At> {
        let promised = -dot(&at.slope, direction);
        if !(promised > 0.0 && promised.is_finite()) {
            return None;
        }
        let noise = NOISE * at.energy.abs();
        let mut length = 1.0;
        for _ in 0..MOST_TRIALS {
            let trial = self.along(at, direction, length, potential);
            let lower = trial.energy <= at.energy - SUFFICIENT * length * promised;
            let hidden = length * promised <= noise && norm(&trial.slope) < norm(&at.slope);
            if (lower || hidden) && self.is_sound(at, &trial, potential) {
                // Secant step: the zero of the slope by linear interpolation.
                let better = length * promised / (promised + dot(&trial.slope, direction));
                let lengthen = first && better > 0.0 && better < LONGEST * length;
                if lengthen && (better / length - 1.0).abs() > OFF {
                    let other = self.along(at, direction, better, potential);
                    let nearer = other.energy < trial.energy;
                    let taken = nearer && self.is_sound(at, &other, potential);
                    return Some(if taken { other } else { trial });
                }
                return Some(trial);
            }
            if promised <= noise {
                return None;
            }
            length *= SHORTER;
        }
        None
    }

    /// Whether energy and forces are finite and no cell becomes nearly flat along the step, where it could turn inside
    /// out.
    fn is_sound(&self, from: &At, to: &At, potential: Potential<'_>) -> bool {
        let Potential { body, theta, .. } = potential;
        let step = difference(&to.displacement, &from.displacement);
        let flattens = |point: usize| {
            let at = body.displacement_gradient(point, &from.displacement);
            flattens(&at, &body.displacement_gradient(point, &step), 1.0)
        };
        to.energy.is_finite()
            && norm(&to.slope).is_finite()
            && !(minds_turned_cells(body, theta) && (0..body.volumes.len()).any(flattens))
    }

    fn along(&self, at: &At, direction: &[f64], length: f64, potential: Potential<'_>) -> At {
        let mut displacement = at.displacement.clone();
        let step = direction.iter().map(|d| length * d);
        self.sparsity.scatter_along(potential.frames, step, &mut displacement);
        self.at(displacement, potential)
    }
}

/// Π of the reference configuration \[stress·length³\], where supports prescribe no motion.
pub(crate) fn energy_at_rest(body: &Body, theta: &[f64]) -> Option<f64> {
    let rest = body.prescribed.iter().all(|u| u.is_none_or(|u| u == 0.0));
    rest.then(|| body.value(&vec![0.0; body.prescribed.len()], theta))
}

/// Length of the series that continues the last estimate, from at least `seen` steps before it; infinite where one of the last two
/// steps lengthened it, or the last increased the residual. Where the body has turned since its stiffness was factorised, forces along stiff
/// directions of that stiffness bend it: steps contract, the residual does not.
fn left_open(lengths: &[f64], forces: &[f64], seen: usize) -> f64 {
    let tail = &lengths[lengths.len().saturating_sub(SEEN + 1)..];
    let of_forces = &forces[forces.len().saturating_sub(2)..];
    let ratios = tail.windows(2).chain(of_forces.windows(2)).map(|pair| pair[1] / pair[0]);
    let ratio = ratios.fold(CONTRACTS, f64::max);
    let [.., last] = tail else { return f64::INFINITY };
    let before = tail.iter().rev().nth(1).map_or(0.0, |before| LEAST * before);
    let known = lengths.len() > seen && ratio < 1.0;
    if known { SAFETY * last.max(before) / (1.0 - ratio) } else { f64::INFINITY }
}

/// Curvature pairs of quasi-Newton steps with one factor, for [`Solver::refine_on`]; begin with none after each factorisation.
#[derive(Default)]
pub struct Pairs(Memory);

/// Step pairs of an L-BFGS iteration. Each change of the gradient is kept with its solve by the frozen stiffness, so
/// that a step needs one back-substitution.
#[derive(Default)]
struct Memory(Vec<Pair>);

/// A step with the change of the slope along it.
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    /// `K⁻¹` times the change.
    solved: Vec<f64>,
    /// Product of step and change.
    work: f64,
    /// Scale of the initial inverse: curvature of the frozen stiffness over that along the step.
    scale: f64,
}

impl Memory {
    /// Two estimates of the error at a state: the slope solved by the frozen stiffness, and the quasi-Newton
    /// direction. The scale of the initial inverse is the largest of all pairs, one at least: a step along stiff directions makes it small,
    /// and soft ones would count for nothing.
    fn estimates(&self, slope: &[f64], solved: &[f64]) -> [Vec<f64>; 2] {
        let scale = self.0.iter().map(|pair| pair.scale).fold(1.0, f64::max);
        [solved.iter().map(|d| scale * d).collect(), self.applied(slope, solved, scale)]
    }

    /// Quasi-Newton direction: minus the updated inverse stiffness times forces, which the frozen stiffness has `solved`.
    fn applied(&self, forces: &[f64], solved: &[f64], scale: f64) -> Vec<f64> {
        let (mut forces, mut direction) = (forces.to_vec(), solved.to_vec());
        let mut parts = Vec::with_capacity(self.0.len());
        for pair in self.0.iter().rev() {
            let part = dot(&pair.step, &forces) / pair.work;
            add(&mut forces, -part, &pair.change);
            add(&mut direction, -part, &pair.solved);
            parts.push(part);
        }
        direction.iter_mut().for_each(|d| *d *= scale);
        for (pair, part) in self.0.iter().zip(parts.into_iter().rev()) {
            let more = part - dot(&pair.change, &direction) / pair.work;
            add(&mut direction, more, &pair.step);
        }
        direction.iter_mut().for_each(|d| *d = -*d);
        direction
    }
}
