//! Descent on the potential energy with one stiffness for many parameter sets: no factorisation per set.
//!
//! Quasi-Newton steps of limited memory (J. Nocedal, Math. Comput. 35, 1980), which begin with the inverse of a stiffness that was
//! factorised once, near to where they are taken, scaled to what the last step found. A step costs a gradient and two
//! back-substitutions, a tenth or less of a Newton step.

use crate::cells::volume_ratios;
use crate::check::check_displacement;
use crate::line_search::{flattens, minds_turned_cells};
use crate::supports::place;
use crate::system::System;
use crate::vector::{dot, norm};
use crate::{SolveError, Solver};
use sinew_energy::Body;
use std::collections::VecDeque;
use std::time::Instant;

/// Steps that are remembered; few enough are taken that more would not be missed.
const MEMORY: usize = 10;
/// The energy must fall by this part of what the slope promises (Armijo's condition, the usual value).
const SUFFICIENT: f64 = 1e-4;
/// Shortening of a step that does not, and how often.
const SHORTER: f64 = 0.4;
const MOST_TRIALS: usize = 20;
/// The first step is lengthened or shortened by what slopes at both of its ends foresee where that differs by more than this part: a
/// stiffness at other parameters is of another size.
const OFF: f64 = 0.2;
/// At most by so much.
const LONGEST: f64 = 50.0;
/// Unbalanced forces \[relative to those of the held state\] below which nothing is left to gain.
const BALANCED: f64 = 1e-13;
/// Rounding errors of energies \[relative\].
const NOISE: f64 = 1e-14;

/// The factorised stiffness of a body at one state, for steps at many parameter sets around it.
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
/// let held = solver.held_stiffness(&known, &[75.0, 75.0])?;
/// let near = held.descend(&known, &[50.0, 90.0], 6)?;
/// let exact = solver.solve(&[50.0, 90.0], &Options::default())?;
/// assert!(near.residual_after < 1e-4 * near.residual_before);
/// assert!((near.energy / exact.energy - 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct HeldStiffness<'p> {
    system: System<'p>,
    /// Displacement of the state, node by node \[length\].
    pub displacement: Vec<f64>,
}

/// What a descent came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Descent {
    /// Displacement `[u_x, u_y, u_z]` node by node \[length\].
    pub displacement: Vec<f64>,
    /// Total potential energy \[stress·length³\].
    pub energy: f64,
    /// Norm of the unbalanced nodal forces where it began \[stress·length²\].
    pub residual_before: f64,
    /// The same where it ended.
    pub residual_after: f64,
    /// Steps that were taken: fewer than allowed where no step lowers the energy, at equilibrium for instance.
    pub steps: usize,
    /// Wall-clock time \[s\].
    pub seconds: f64,
}

/// A state of a descent, in free degrees of freedom.
struct At {
    displacement: Vec<f64>,
    energy: f64,
    /// Derivative of the energy.
    slope: Vec<f64>,
}

impl<'p> Solver<'p> {
    /// The stiffness at a displacement \[length\], best an equilibrium in the middle of the parameters' ranges. An indefinite one is shifted.
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, [`SolveError::Inadmissible`] where that inverts a cell,
    /// [`SolveError::Singular`], [`SolveError::OutOfMemory`].
    pub fn held_stiffness(
        &self,
        displacement: &[f64],
        theta: &[f64],
    ) -> Result<HeldStiffness<'p>, SolveError> {
        let mut own = self.fresh()?;
        own.visit(displacement, (theta, 1.0), None)?;
        own.system.factorise(true).ok_or(SolveError::Singular)?;
        Ok(HeldStiffness { system: own.system, displacement: displacement.to_vec() })
    }
}

impl<'p> HeldStiffness<'p> {
    /// The body.
    pub fn body(&self) -> &'p Body {
        self.system.body
    }

    /// At most `steps` steps towards lower energy at θ, from a displacement \[length\] near to equilibrium. Prescribed components are put in
    /// their places first.
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, [`SolveError::Inadmissible`] where that inverts a cell.
    pub fn descend(
        &self,
        from: &[f64],
        theta: &[f64],
        steps: usize,
    ) -> Result<Descent, SolveError> {
        self.descend_on(self.system.body, from, theta, steps)
    }

    /// The same for another body with the same cells between its nodes and the same held components: another shape, another material,
    /// other loads. The less alike both are, the more steps it takes.
    ///
    /// # Errors
    /// As for [`HeldStiffness::descend`], and [`SolveError::OtherBody`].
    pub fn descend_on(
        &self,
        body: &Body,
        from: &[f64],
        theta: &[f64],
        steps: usize,
    ) -> Result<Descent, SolveError> {
        self.check(body)?;
        self.system.relax((body, theta), from, steps, BALANCED)
    }

    /// Refuses a body that the unknowns of this stiffness are not those of.
    fn check(&self, body: &Body) -> Result<(), SolveError> {
        let own = self.system.body;
        if std::ptr::eq(own, body) {
            return Ok(());
        }
        let held = |body: &Body| body.prescribed.iter().map(Option::is_some).collect::<Vec<_>>();
        let what = match () {
            () if own.nodes != body.nodes => "nodes",
            () if own.cells != body.cells => "cells",
            () if held(own) != held(body) => "held components",
            () if own.frames != body.frames => "directions of supports",
            () => return Ok(()),
        };
        Err(SolveError::OtherBody { what })
    }
}

impl System<'_> {
    /// Descends with the factor that it has, until no more than a part of the forces is unbalanced.
    pub(crate) fn relax(
        &self,
        potential: (&Body, &[f64]),
        from: &[f64],
        steps: usize,
        enough: f64,
    ) -> Result<Descent, SolveError> {
        let (start, (body, theta)) = (Instant::now(), potential);
        body.check_theta(theta)?;
        check_displacement(body, from)?;
        let mut first = from.to_vec();
        place(body, 1.0, &mut first);
        let mut at = self.at(first, potential);
        if !(at.energy.is_finite() && at.slope.iter().all(|g| g.is_finite())) {
            let ratios = volume_ratios(body, &at.displacement).into_iter().enumerate();
            let worst = ratios.min_by(|(_, a), (_, b)| a.total_cmp(b));
            let cell = worst.map_or(0, |(point, _)| point / body.points_per_cell);
            return Err(SolveError::Inadmissible { cell });
        }
        let residual_before = norm(&at.slope);
        let balanced = enough * self.assembly.force_scale;
        let mut pairs: VecDeque<Pair> = VecDeque::with_capacity(MEMORY);
        let mut taken = 0;
        while taken < steps && norm(&at.slope) > balanced {
            let direction = self.direction(&at.slope, &pairs);
            let first = pairs.is_empty();
            let Some(next) = self.step_along(&at, &direction, potential, first) else { break };
            if pairs.len() == MEMORY {
                pairs.pop_front();
            }
            pairs.extend(self.pair(&at, &next));
            at = next;
            taken += 1;
        }
        Ok(Descent {
            residual_before,
            residual_after: norm(&at.slope),
            energy: at.energy,
            displacement: at.displacement,
            steps: taken,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    fn at(&self, displacement: Vec<f64>, (body, theta): (&Body, &[f64])) -> At {
        let mut gradient = vec![0.0; displacement.len()];
        let energy = body.value_and_gradient(&displacement, theta, &mut gradient);
        At { displacement, energy, slope: self.sparsity.gather(&gradient).collect() }
    }

    /// `K⁻¹` times forces.
    fn solved(&self, forces: &[f64]) -> Vec<f64> {
        let mut change = forces.to_vec();
        self.factor.solve(&mut change);
        change
    }

    /// Minus the inverse that the remembered steps make of the held one, times the slope.
    fn direction(&self, slope: &[f64], pairs: &VecDeque<Pair>) -> Vec<f64> {
        let mut forces = slope.to_vec();
        let mut parts = Vec::with_capacity(pairs.len());
        for pair in pairs.iter().rev() {
            let part = dot(&pair.step, &forces) / pair.work;
            add(&mut forces, -part, &pair.change);
            parts.push(part);
        }
        let mut direction = self.solved(&forces);
        if let Some(last) = pairs.back() {
            direction.iter_mut().for_each(|d| *d *= last.scale);
        }
        for (pair, part) in pairs.iter().zip(parts.into_iter().rev()) {
            let more = part - dot(&pair.change, &direction) / pair.work;
            add(&mut direction, more, &pair.step);
        }
        direction.iter_mut().for_each(|d| *d = -*d);
        direction
    }

    /// The longest of some steps along a direction that lowers the energy enough.
    fn step_along(
        &self,
        at: &At,
        direction: &[f64],
        potential: (&Body, &[f64]),
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
                // Where the energy's slope vanishes, if that changes evenly.
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

    /// Whether energy and forces are finite, and no cell is as good as flat on the way: it might come out turned inside.
    fn is_sound(&self, from: &At, to: &At, (body, theta): (&Body, &[f64])) -> bool {
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

    fn along(&self, at: &At, direction: &[f64], length: f64, potential: (&Body, &[f64])) -> At {
        let mut displacement = at.displacement.clone();
        self.sparsity.scatter(direction.iter().map(|d| length * d), &mut displacement);
        self.at(displacement, potential)
    }

    /// What a step tells of the stiffness, where that is positive along it.
    fn pair(&self, from: &At, to: &At) -> Option<Pair> {
        let moved: Vec<f64> =
            to.displacement.iter().zip(&from.displacement).map(|(b, a)| b - a).collect();
        let step: Vec<f64> = self.sparsity.gather(&moved).collect();
        let change: Vec<f64> = to.slope.iter().zip(&from.slope).map(|(b, a)| b - a).collect();
        let work = dot(&step, &change);
        let scale = work / dot(&change, &self.solved(&change));
        (work > 0.0 && scale.is_finite()).then_some(Pair { step, change, work, scale })
    }
}

/// A step with the change of the slope along it.
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    /// Their product.
    work: f64,
    /// The stiffness held, relative to that along the step.
    scale: f64,
}

fn add(to: &mut [f64], factor: f64, from: &[f64]) {
    to.iter_mut().zip(from).for_each(|(t, f)| *t += factor * f);
}
