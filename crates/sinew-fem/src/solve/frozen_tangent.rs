//! Descent on the potential energy with a frozen stiffness for many parameter sets: no factorisation per set.
//!
//! Limited-memory quasi-Newton steps (L-BFGS; J. Nocedal, Math. Comput. 35, 1980). The initial inverse is that of a stiffness
//! factorised once at a nearby state, scaled by the last step. A step costs a gradient and two
//! back-substitutions, a tenth or less of a Newton step.

use crate::elements::cells::inadmissible;
use crate::elements::check::check_state;
use crate::elements::state::load_gradient;
use crate::elements::supports::place;
use crate::elements::system::System;
use crate::linear::vector::{dot, norm, relative};
use crate::solve::line_search::{flattens, minds_turned_cells};
use crate::{SolveError, Solver};
use sinew_energy::{Body, Frames};
use sinew_num::Mat3;
use std::borrow::Cow;
use std::collections::{HashSet, VecDeque};
use std::time::Instant;

/// Step pairs kept by the L-BFGS update; few steps are taken, so that more pairs would not help.
const MEMORY: usize = 10;
/// Constant of the sufficient decrease (Armijo) condition (Nocedal & Wright, 3.1).
const SUFFICIENT: f64 = 1e-4;
/// Backtracking factor, and the largest number of trials.
const SHORTER: f64 = 0.4;
const MOST_TRIALS: usize = 20;
/// Least relative change of the first step's length that a secant step makes: the frozen stiffness may have another
/// scale.
const OFF: f64 = 0.2;
/// Largest rescaling of the first step.
const LONGEST: f64 = 50.0;
/// Residual \[relative to loads and reactions\] at which a descent ends: rounding error of the forces.
pub(crate) const BALANCED: f64 = 1e-13;
/// Cosine below which two directions count as perpendicular.
const ACROSS: f64 = 0.1;
/// Rounding errors of energies \[relative\].
pub(crate) const NOISE: f64 = 1e-14;

/// Frozen stiffness of a body at one state (modified Newton): one factorisation for quasi-Newton steps at many parameter sets.
///
/// ```
/// # use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
/// use sinew_fem::{Options, Solver};
/// let beam = Scene::new(sinew_mesh::box_tetrahedra([30.0, 10.0, 10.0], [6, 2, 2]), NeoHookean)
///     .parameter(Parameter::log("mu", "kPa", 50.0..=100.0))
///     .parameter(Parameter::log("lambda", "kPa", 50.0..=100.0))
///     .load(Load::BodyForce([0.0, 0.0, -1e-2])) // kPa/mm
///     .support(Support::clamped("x_min"))
///     .lower()?;
/// let mut solver = Solver::new(&beam)?;
/// let known = solver.solve(&[75.0, 75.0], &Options::default())?.displacement;
/// let held = solver.frozen_tangent(&known, &[75.0, 75.0])?;
/// let near = held.descend(&known, &[50.0, 90.0], 6)?;
/// let exact = solver.solve(&[50.0, 90.0], &Options::default())?;
/// assert!(near.unbalanced() < 1e-4);
/// assert!((near.energy / exact.energy - 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias("frozen stiffness", "modified Newton", "quasi-Newton"))]
pub struct FrozenTangent<'p> {
    system: System<'p>,
    /// Displacement of the state, node by node \[length\].
    pub displacement: Vec<f64>,
}

/// Result of a quasi-Newton descent.
#[derive(Clone, Debug, PartialEq)]
pub struct Descent {
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
    /// Number of steps; fewer than allowed where no step lowers the energy, as at equilibrium.
    pub steps: usize,
    /// Wall-clock time \[s\].
    pub seconds: f64,
}

impl Descent {
    /// Final residual \[relative to loads and reactions\]. A value of about one is far from equilibrium, however much
    /// the residual fell. [`Solver::error_estimate`] gives the distance.
    pub fn unbalanced(&self) -> f64 {
        relative(self.residual_after, self.force_scale)
    }
}

/// A state of a descent, in free degrees of freedom.
pub(crate) struct At {
    pub displacement: Vec<f64>,
    pub energy: f64,
    /// Derivative of the energy.
    pub slope: Vec<f64>,
    /// Norm of the forces on supports.
    reactions: f64,
}

impl At {
    /// Norm of loads and reactions.
    pub(crate) fn force_scale(&self, Potential { body, theta, .. }: Potential<'_>) -> f64 {
        norm(&load_gradient(body, &self.displacement, theta)) + self.reactions
    }
}

impl<'p> Solver<'p> {
    /// The stiffness at a displacement \[length\], best an equilibrium in the middle of the parameters' ranges. An indefinite one is shifted.
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, [`SolveError::Inadmissible`] where that inverts a cell,
    /// [`SolveError::Singular`], [`SolveError::OutOfMemory`].
    pub fn frozen_tangent(
        &self,
        displacement: &[f64],
        theta: &[f64],
    ) -> Result<FrozenTangent<'p>, SolveError> {
        let mut own = self.fresh()?;
        own.visit(displacement, (theta, 1.0), None)?;
        own.system.factorise(true).ok_or(SolveError::Singular)?;
        Ok(FrozenTangent { system: own.system, displacement: displacement.to_vec() })
    }
}

impl<'p> FrozenTangent<'p> {
    /// The body.
    pub fn body(&self) -> &'p Body {
        self.system.body
    }

    /// At most `steps` steps towards lower energy at θ, from a displacement \[length\] near to equilibrium. Prescribed components are put in
    /// their places first.
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, [`SolveError::Inadmissible`] where that inverts a cell.
    #[doc(alias("L-BFGS", "quasi-Newton"))]
    pub fn descend(
        &self,
        from: &[f64],
        theta: &[f64],
        steps: usize,
    ) -> Result<Descent, SolveError> {
        let body = self.system.body;
        let potential = Potential { body, theta, frames: &body.frames };
        self.system.relax(potential, from, steps, BALANCED)
    }

    /// Requires another body with as many held directions at each node and the same cells, up to the diagonals that linear ones are cut along.
    ///
    /// # Errors
    /// [`SolveError::OtherBody`], [`SolveError::NoPotential`].
    pub fn suits(&self, body: &Body) -> Result<(), SolveError> {
        self.frames_of(body).map(|_| ())
    }

    /// Quasi-Newton steps on another body with the same cells and as many held directions at each node: another shape,
    /// material or load. The number of steps grows with the difference of both bodies. They do not converge where
    /// both are nearly incompressible ([`Descent::unbalanced`] stays about one), because changes of volume are stiff.
    ///
    /// # Errors
    /// As for [`FrozenTangent::descend`], and [`SolveError::OtherBody`].
    pub fn descend_on(
        &self,
        body: &Body,
        from: &[f64],
        theta: &[f64],
        steps: usize,
    ) -> Result<Descent, SolveError> {
        let frames = self.frames_of(body)?;
        self.system.relax(Potential { body, theta, frames: &frames }, from, steps, BALANCED)
    }

    /// Frames of another body, with its free axes rotated as near as possible to those of this stiffness; an error if
    /// cells or supports differ.
    fn frames_of<'b>(&self, body: &'b Body) -> Result<Cow<'b, Frames>, SolveError> {
        let own = self.system.body;
        if !body.has_potential() {
            return Err(SolveError::NoPotential);
        }
        let refuse = |what| Err(SolveError::OtherBody { what });
        if own.nodes != body.nodes {
            return refuse("nodes");
        }
        if own.cells != body.cells && !shares_edges(own, body) {
            return refuse("cells");
        }
        let held = |body: &Body, node: usize| -> [bool; 3] {
            std::array::from_fn(|i| body.prescribed[3 * node + i].is_some())
        };
        let mut frames = Cow::Borrowed(&body.frames);
        for node in 0..body.nodes {
            let [ours, theirs] = [held(own, node), held(body, node)];
            let count = |held: [bool; 3]| held.into_iter().filter(|h| *h).count();
            if count(ours) != count(theirs) {
                return refuse("held components");
            }
            if ours == theirs && own.frames.get(node) == body.frames.get(node) {
                continue;
            }
            let axes = |body: &Body, of: [bool; 3], which: bool| -> Vec<[f64; 3]> {
                let all = (0..3).filter(|&i| of[i] == which);
                all.map(|i| body.frames.axis(3 * node + i)).collect()
            };
            let mut fixed = axes(body, theirs, true).into_iter();
            let free = nearest(&axes(own, ours, false), &axes(body, theirs, false));
            let Some(mut free) = free.map(Vec::into_iter) else {
                return refuse("directions of supports");
            };
            let mut row = |held: bool| if held { fixed.next() } else { free.next() };
            let rows = ours.map(|held| row(held).unwrap_or_default());
            frames.to_mut().insert(node, Mat3(rows));
        }
        Ok(frames)
    }
}

/// Whether linear cells share half of their edges, as those cut from the same hexahedra along other diagonals do.
fn shares_edges(own: &Body, other: &Body) -> bool {
    let edges = |body: &Body| -> HashSet<[usize; 2]> {
        let pairs = body.cell_nodes().flat_map(|cell| cell.iter().map(move |&a| (a, cell)));
        pairs.flat_map(|(a, cell)| cell.iter().map(move |&b| [a, b])).collect()
    };
    let linear = [own, other].iter().all(|body| body.nodes_per_cell == body.element().corners);
    let (own, other) = (edges(own), edges(other));
    linear && 2 * own.intersection(&other).count() >= own.len().max(other.len())
}

/// Orthonormal basis of `space`, each vector the nearest to that of `to`, in order; `None` where one is nearly
/// perpendicular to the space.
fn nearest(to: &[[f64; 3]], space: &[[f64; 3]]) -> Option<Vec<[f64; 3]>> {
    let mut found: Vec<[f64; 3]> = Vec::new();
    for vector in to {
        let mut own = [0.0; 3];
        space.iter().for_each(|axis| add(&mut own, dot(vector, axis), axis));
        for other in &found {
            let along = dot(&own, other);
            add(&mut own, -along, other);
        }
        let length = norm(&own);
        if length < ACROSS {
            return None;
        }
        found.push(own.map(|x| x / length));
    }
    Some(found)
}

/// Potential that a descent lowers, and the frames of its unknowns.
#[derive(Clone, Copy)]
pub(crate) struct Potential<'a> {
    pub body: &'a Body,
    pub theta: &'a [f64],
    pub frames: &'a Frames,
}

impl System<'_> {
    /// Descends with the last factor until the relative residual is at most `enough`.
    pub(crate) fn relax(
        &self,
        potential: Potential<'_>,
        from: &[f64],
        steps: usize,
        enough: f64,
    ) -> Result<Descent, SolveError> {
        let (start, Potential { body, theta, .. }) = (Instant::now(), potential);
        check_state(body, from, theta)?;
        let mut first = from.to_vec();
        place(body, 1.0, &mut first);
        let mut at = self.at(first, potential);
        if !(at.energy.is_finite() && at.slope.iter().all(|g| g.is_finite())) {
            return Err(inadmissible(body, &at.displacement));
        }
        let residual_before = norm(&at.slope);
        let (mut memory, mut taken) = (Memory::default(), 0);
        while taken < steps && norm(&at.slope) > enough * at.force_scale(potential) {
            let direction = memory.direction(self, &at, potential.frames);
            let first = memory.pairs.is_empty();
            let Some(next) = self.step_along(&at, &direction, potential, first) else { break };
            at = next;
            taken += 1;
        }
        Ok(Descent {
            residual_before,
            residual_after: norm(&at.slope),
            force_scale: at.force_scale(potential),
            energy: at.energy,
            displacement: at.displacement,
            steps: taken,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    pub(crate) fn at(&self, displacement: Vec<f64>, potential: Potential<'_>) -> At {
        let Potential { body, theta, frames } = potential;
        let mut gradient = vec![0.0; displacement.len()];
        let energy = body.value_and_gradient(&displacement, theta, &mut gradient);
        let slope: Vec<f64> = self.sparsity.gather_along(frames, &gradient).collect();
        // Frames are orthonormal: without its free components the gradient is that of the supports.
        self.sparsity.scatter_along(frames, slope.iter().map(|g| -g), &mut gradient);
        At { displacement, energy, slope, reactions: norm(&gradient) }
    }

    /// `K⁻¹` times forces.
    fn solved(&self, forces: &[f64]) -> Vec<f64> {
        let mut change = forces.to_vec();
        self.back_substitute(&mut change);
        change
    }

    /// Longest step along a direction, by backtracking, that meets the decrease condition.
    pub(crate) fn step_along(
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
        let step: Vec<f64> =
            to.displacement.iter().zip(&from.displacement).map(|(b, a)| b - a).collect();
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

/// Step pairs of an L-BFGS iteration. Each change of the gradient is kept with its solve by the frozen stiffness, so
/// that a step needs one back-substitution.
#[derive(Default)]
pub(crate) struct Memory {
    pub pairs: VecDeque<Pair>,
    last: Option<Last>,
}

/// The state that the last direction began at.
struct Last {
    displacement: Vec<f64>,
    slope: Vec<f64>,
    /// `K⁻¹` times the slope.
    solved: Vec<f64>,
}

/// A step with the change of the slope along it.
pub(crate) struct Pair {
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
    /// Quasi-Newton direction: minus the updated inverse stiffness times the slope.
    pub(crate) fn direction(&mut self, system: &System<'_>, at: &At, frames: &Frames) -> Vec<f64> {
        let solved = system.solved(&at.slope);
        let state = Last {
            displacement: at.displacement.clone(),
            slope: at.slope.clone(),
            solved: solved.clone(),
        };
        let last = self.last.replace(state);
        if let Some(pair) =
            last.and_then(|last| Pair::between(&last, at, &solved, (system, frames)))
        {
            if self.pairs.len() == MEMORY {
                self.pairs.pop_front();
            }
            self.pairs.push_back(pair);
        }
        self.applied(&at.slope, solved, self.scale())
    }

    /// Scale of the initial inverse, from the last pair.
    fn scale(&self) -> f64 {
        self.pairs.back().map_or(1.0, |pair| pair.scale)
    }

    /// Two estimates of the error at the state of the last direction: the slope solved by the frozen stiffness, and the quasi-Newton
    /// direction. The scale of the initial inverse is the largest of all pairs, one at least: a step along stiff directions makes it small,
    /// and soft ones would count for nothing.
    pub(crate) fn estimates(&self) -> [Vec<f64>; 2] {
        let Some(Last { slope, solved, .. }) = &self.last else { return Default::default() };
        let scale = self.pairs.iter().map(|pair| pair.scale).fold(1.0, f64::max);
        [solved.iter().map(|d| scale * d).collect(), self.applied(slope, solved.clone(), scale)]
    }

    /// Minus the updated inverse times forces, which the frozen stiffness has `solved`.
    fn applied(&self, forces: &[f64], solved: Vec<f64>, scale: f64) -> Vec<f64> {
        let (mut forces, mut direction) = (forces.to_vec(), solved);
        let mut parts = Vec::with_capacity(self.pairs.len());
        for pair in self.pairs.iter().rev() {
            let part = dot(&pair.step, &forces) / pair.work;
            add(&mut forces, -part, &pair.change);
            add(&mut direction, -part, &pair.solved);
            parts.push(part);
        }
        direction.iter_mut().for_each(|d| *d *= scale);
        for (pair, part) in self.pairs.iter().zip(parts.into_iter().rev()) {
            let more = part - dot(&pair.change, &direction) / pair.work;
            add(&mut direction, more, &pair.step);
        }
        direction.iter_mut().for_each(|d| *d = -*d);
        direction
    }
}

impl Pair {
    /// Curvature pair of a step, where the stiffness is positive along it.
    fn between(
        from: &Last,
        to: &At,
        solved: &[f64],
        (system, frames): (&System<'_>, &Frames),
    ) -> Option<Self> {
        let minus =
            |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        let moved = minus(&to.displacement, &from.displacement);
        let step: Vec<f64> = system.sparsity.gather_along(frames, &moved).collect();
        let change = minus(&to.slope, &from.slope);
        let solved = minus(solved, &from.solved);
        let work = dot(&step, &change);
        let scale = work / dot(&change, &solved);
        (work > 0.0 && scale > 0.0 && scale.is_finite()).then_some(Self {
            step,
            change,
            solved,
            work,
            scale,
        })
    }
}

fn add(to: &mut [f64], factor: f64, from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(t, f)| *t += factor * f);
}
