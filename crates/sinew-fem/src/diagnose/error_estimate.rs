//! A posteriori error of a displacement: its distance to the equilibrium that Newton's method converges to.
//!
//! A Newton step alone is no estimate: far from equilibrium it may be a thousandth of the error. A simplified Newton
//! step with the same stiffness follows it. If the second step is much shorter than the first, there is an equilibrium
//! nearby and the steps converge to it (Newton–Kantorovich theorem; P. Deuflhard, Newton Methods for Nonlinear
//! Problems, 2011, chapter 2).

use crate::linear::{add, difference, dot, relative};
use crate::solve::energy_at_rest;
use crate::{NewtonStep, Result, SolveError, Solver};
use sinew_energy::metrics::mean_and_largest;
use std::time::Instant;
use thiserror::Error;

/// Largest contraction ratio of two steps that counts as converging: the Kantorovich quantity h is about twice this
/// ratio, and convergence is certain for h ≤ 1/2.
const CONTRACTS: f64 = 0.25;
/// Number of simplified steps; each costs a gradient and a back-substitution.
const SIMPLIFIED: usize = 2;
/// Most Newton steps before a displacement counts as far from equilibrium, for each about squares a contraction ratio below one; and the
/// most where they have moved it little, for slivers delay the contraction.
const MOST_STEPS: [usize; 2] = [4, 8];
/// Move \[relative to the displacement\] up to which more steps are taken: longer ones may lead to another equilibrium.
const NEAR: f64 = 0.1;

/// A posteriori error estimate of a displacement, from [`Solver::error_estimate`].
#[doc(alias = "a posteriori error estimate")]
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// Norm of the unbalanced nodal forces \[relative to loads and reactions at this displacement\].
    pub residual: f64,
    /// Total potential energy Π at this displacement \[stress·length³\]; +∞ where it is not admissible.
    pub energy: f64,
    /// Number of Newton steps to the equilibrium; each costs a factorisation.
    pub newton_steps: usize,
    /// The distance to the equilibrium nearby, or why none was found.
    pub distance: Result<Distance, NotNearEquilibrium>,
    /// Wall-clock time \[s\].
    pub seconds: f64,
}

/// Distance of a displacement from a stable equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct Distance {
    /// Energy norm `‖u − û‖_K` with the stiffness K near the equilibrium [√(stress·length³)].
    pub energy_norm: f64,
    /// Mean nodal distance, including the steps that would follow \[length\].
    pub mean: f64,
    /// Largest nodal distance, including the steps that would follow \[length\].
    pub largest: f64,
    /// Contraction ratio of the last simplified Newton step.
    pub contraction: f64,
    /// Displacement after the last step, the best approximation of the equilibrium, node by node \[length\].
    pub equilibrium: Vec<f64>,
    /// Estimated mean nodal error of `equilibrium` \[length\]: four times the geometric series of the steps that would
    /// follow, at the largest contraction ratio.
    pub left_open: f64,
}

/// Safety factor on the series of steps that would follow: simplified steps contract ever more slowly, because the
/// error turns towards the slowest direction.
const SAFETY: f64 = 4.0;

/// Reason for which a displacement has no error estimate.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum NotNearEquilibrium {
    /// A cell is inverted, or the energy overflows.
    #[error("cell {cell} is inverted or its energy overflows")]
    Inadmissible { cell: usize },
    /// Newton's method does not contract.
    #[error(
        "not near an equilibrium: {steps} Newton steps do not contract; the residual is {residual:.1e} of loads and reactions"
    )]
    Diverges { steps: usize, residual: f64 },
    /// No step lowers the energy.
    #[error(
        "not near an equilibrium: no Newton step lowers the energy; the residual is {residual:.1e} of loads and reactions"
    )]
    Stuck { residual: f64 },
    /// The stiffness is not positive definite there.
    #[error(
        "not near a stable equilibrium: the stiffness is indefinite after {steps} Newton steps; the body may snap or buckle, \
         or have no equilibrium under this load"
    )]
    Indefinite { steps: usize },
    /// The equilibrium nearby has more energy than the reference configuration.
    #[error(
        "near another equilibrium than that of a rising load: its energy {energy:.4e} is above {at_rest:.4e}, that of the body \
         at rest"
    )]
    AboveRest { energy: f64, at_rest: f64 },
}

impl Solver<'_> {
    /// Distance of any displacement \[length\] to the equilibrium at θ near it. Prescribed components are set first.
    ///
    /// Takes Newton steps until two simplified steps follow, each at most a quarter as long as the step before it: four at most, or eight
    /// while they move the displacement by less than a tenth. A good prediction needs one Newton step: a factorisation and three back-substitutions.
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
    /// let [guess, truth] = [55.0, 50.0].map(|mu| solver.solve(&[mu, 90.0], &Options::default()));
    /// let (guess, truth) = (guess?.displacement, truth?.displacement);
    /// let estimate = solver.error_estimate(&guess, &[50.0, 90.0])?;
    /// let mean = sinew_energy::metrics::displacement_error(&guess, &truth).iter().sum::<f64>() / beam.nodes as f64;
    /// assert!((estimate.distance?.mean / mean - 1.0).abs() < 1e-3); // of 0.02 mm
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, or [`SolveError::OutOfMemory`]. A displacement that is not near an equilibrium is no error:
    /// see [`ErrorEstimate::distance`].
    pub fn error_estimate(&mut self, displacement: &[f64], theta: &[f64]) -> Result<ErrorEstimate> {
        self.error_estimate_within(displacement, theta, MOST_STEPS[1])
    }

    /// [`Solver::error_estimate`] that gives up early: after `most` Newton steps it goes on only while each step
    /// reduces the residual to a quarter or less. A solve from rest may then be faster.
    ///
    /// # Errors
    /// As for [`Solver::error_estimate`].
    pub fn error_estimate_within(
        &mut self,
        displacement: &[f64],
        theta: &[f64],
        most: usize,
    ) -> Result<ErrorEstimate> {
        let start = Instant::now();
        let from = self.placed(displacement, theta)?;
        let mut estimate = ErrorEstimate {
            residual: f64::INFINITY,
            energy: f64::INFINITY,
            newton_steps: 0,
            distance: Err(NotNearEquilibrium::Inadmissible { cell: 0 }),
            seconds: 0.0,
        };
        let distance = self.contract((displacement, from), (theta, most), &mut estimate);
        estimate.distance = match distance {
            Ok(distance) => distance,
            Err(SolveError::Inadmissible { cell }) => {
                Err(NotNearEquilibrium::Inadmissible { cell })
            }
            Err(SolveError::Singular) => {
                Err(NotNearEquilibrium::Indefinite { steps: estimate.newton_steps })
            }
            Err(other) => return Err(other),
        };
        estimate.seconds = start.elapsed().as_secs_f64();
        Ok(estimate)
    }

    /// Takes Newton steps until they contract; writes residual and energy of the given displacement to `estimate`.
    fn contract(
        &mut self,
        (displacement, mut from): (&[f64], Vec<f64>),
        (theta, most): (&[f64], usize),
        estimate: &mut ErrorEstimate,
    ) -> Result<Result<Distance, NotNearEquilibrium>> {
        for steps in 1..=MOST_STEPS[1] {
            let step = self.step_from(&from, theta, &mut None)?;
            let residual = relative(step.residual_before, step.force_scale);
            if steps == 1 {
                (estimate.residual, estimate.energy) = (residual, step.energy_before);
            }
            estimate.newton_steps = steps;
            let moved = mean_and_largest(&difference(&step.displacement, displacement))[0];
            let is_near = moved <= NEAR * mean_and_largest(&step.displacement)[0];
            let ends = steps >= MOST_STEPS[usize::from(is_near)];
            let balanced = step.residual_before <= self.system.assembly.tolerance();
            if step.shift == 0.0 && (step.length == 1.0 || balanced) {
                let found = self.simplified_steps((displacement, &from), &step, theta);
                if let Some((distance, energy)) = found {
                    let noise = self.system.assembly.energy_noise;
                    let at_rest = energy_at_rest(self.body(), theta);
                    return Ok(match at_rest.filter(|rest| energy > rest + noise) {
                        Some(at_rest) => Err(NotNearEquilibrium::AboveRest { energy, at_rest }),
                        None => Ok(distance),
                    });
                }
            } else if step.length == 0.0 {
                return Ok(Err(NotNearEquilibrium::Stuck { residual }));
            } else if ends && step.shift > 0.0 {
                return Ok(Err(NotNearEquilibrium::Indefinite { steps }));
            }
            from = step.displacement;
            if ends || steps >= most && step.residual_after > CONTRACTS * step.residual_before {
                break;
            }
        }
        let residual = self.visit(&from, (theta, 1.0), None).map_or(f64::INFINITY, |()| {
            let assembly = &self.system.assembly;
            relative(self.norm_of_free(&assembly.gradient), assembly.force_scale)
        });
        Ok(Err(NotNearEquilibrium::Diverges { steps: estimate.newton_steps, residual }))
    }

    /// Distance of a displacement to the end of simplified steps after a whole Newton step, if each is at most a quarter of the one before,
    /// and the energy before the last. A single one may be
    /// short by chance: in a slender body that rotates, the axial stresses are corrected before the bending. The steps that would follow are
    /// a geometric series with the contraction ratio.
    fn simplified_steps(
        &self,
        (displacement, from): (&[f64], &[f64]),
        step: &NewtonStep,
        theta: &[f64],
    ) -> Option<(Distance, f64)> {
        let mut gradient = vec![0.0; from.len()];
        let mut at = step.displacement.clone();
        let mut last = difference(&at, from);
        let mut size = [step.energy_norm, mean_and_largest(&last)[0]];
        let (mut ratio, mut slowest, mut energy): (f64, f64, f64) = (0.0, 0.0, step.energy_after);
        for _ in 0..SIMPLIFIED {
            energy = self.body().value_and_gradient(&at, theta, &mut gradient);
            let residual = self.norm_of_free(&gradient);
            if residual <= self.system.assembly.tolerance() {
                break;
            }
            let next = self.system.newton_step(&gradient);
            let work = -dot(&gradient, &next);
            let now = [if work < 0.0 { 0.0 } else { work.sqrt() }, mean_and_largest(&next)[0]];
            let finite = [energy, residual].iter().chain(&now).all(|x| x.is_finite());
            ratio = (now[0] / size[0]).max(now[1] / size[1]);
            slowest = slowest.max(ratio);
            if !finite || ratio > CONTRACTS {
                return None;
            }
            add(&mut at, 1.0, &next);
            (last, size) = (next, now);
        }
        if !self.body().value(&at, theta).is_finite() {
            return None;
        }
        let error = difference(displacement, &at);
        let free: Vec<f64> = self.system.sparsity.gather(&error).collect();
        let mut forces = vec![0.0; free.len()];
        self.system.apply(&free, &mut forces);
        let open = |ratio: f64| ratio / (1.0 - ratio);
        let ([mean, largest], [mean_of_last, largest_of_last]) =
            (mean_and_largest(&error), mean_and_largest(&last));
        let distance = Distance {
            energy_norm: dot(&free, &forces).max(0.0).sqrt(),
            mean: mean + open(ratio) * mean_of_last,
            largest: largest + open(ratio) * largest_of_last,
            contraction: ratio,
            equilibrium: at,
            left_open: SAFETY * open(slowest) * mean_of_last,
        };
        Some((distance, energy))
    }
}
