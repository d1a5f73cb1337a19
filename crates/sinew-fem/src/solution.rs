//! What a solve returns.

use crate::newton::Equilibrium;
use crate::system::System;
use crate::{History, LockingWarning};
use std::time::Instant;

/// An equilibrium of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Displacement `[u_x, u_y, u_z]` node by node \[length\].
    pub displacement: Vec<f64>,
    /// Total potential energy \[stress·length³\].
    pub energy: f64,
    /// Parameters of law and loads.
    pub theta: Vec<f64>,
    /// Fraction of all loads and prescribed motions, 1 but on the way along a [`crate::Curve`].
    pub load_factor: f64,
    /// Norm of the unbalanced nodal forces \[stress·length²\].
    pub residual: f64,
    /// Norm of the loads and reactions \[stress·length²\], to compare the residual with.
    pub force_scale: f64,
    /// Least volume ratio J of all cells.
    pub least_volume_ratio: f64,
    /// Number of negative eigenvalues of the last stiffness: 0 for a stable equilibrium.
    pub negative_pivots: usize,
    /// Elements that are too stiff for this body, so that the displacement is too small.
    pub locking: Option<LockingWarning>,
    /// Number of load steps, 1 when the whole load was taken at once; steps of softer bodies, by way of which a nearly incompressible one
    /// is reached, count too, as their states do in the history.
    pub load_steps: usize,
    /// Whether an indefinite stiffness was met on the way: by load steps the body has snapped from one branch of equilibria to another; at
    /// once, or from a state near it, the search may have passed equilibria that a rising load stops at, see
    /// [`crate::Solver::under_rising_load`].
    pub jumped: bool,
    /// All iterations.
    pub history: History,
    /// Wall-clock time of the solve \[s\].
    pub seconds: f64,
}

impl Solution {
    /// Of what was found last.
    pub(crate) fn new(
        system: &System<'_>,
        (found, load_steps): (Equilibrium, usize),
        theta: &[f64],
        history: History,
        start: Instant,
    ) -> Self {
        Self {
            displacement: found.unknowns.displacement,
            // The sum over all cells in one order, the same as every reader of the potential gets.
            energy: system.assembly.energy,
            theta: theta.to_vec(),
            load_factor: found.load_factor,
            residual: found.residual.force,
            force_scale: found.force_scale,
            least_volume_ratio: found.least_volume_ratio,
            negative_pivots: found.negative_pivots,
            locking: system.locking(theta),
            load_steps,
            jumped: found.jumped,
            history,
            seconds: start.elapsed().as_secs_f64(),
        }
    }

    /// Whether the equilibrium is a minimum of the potential: small disturbances die out.
    pub fn is_stable(&self) -> bool {
        self.negative_pivots == 0
    }

    /// Number of Newton iterations.
    pub fn iterations(&self) -> usize {
        self.history.steps()
    }
}

/// When loads are raised step by step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LoadSteps {
    /// Where the whole load at once fails, which takes the fewest iterations. A body with several stable equilibria comes to one of them.
    #[default]
    WhenNeeded,
    /// Always, from rest: the equilibrium that the body comes to under a load that rises slowly, until it snaps. States to start from are not
    /// read.
    Always,
}

/// Limits and accuracy of a solve, and how loads are raised where the whole at once fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Most states that are assembled, all load steps together. Hard bodies take a few hundred.
    pub iterations: usize,
    /// Most of them at one load: searches that succeed take fewer, and beyond them smaller load steps are cheaper.
    pub iterations_per_load: usize,
    /// When loads are raised step by step: for bodies with several stable equilibria.
    pub load_steps: LoadSteps,
    /// Largest first load step, as a fraction of the load. Slender bodies start with less, by the linear model at rest.
    pub first_load_step: f64,
    /// Most that a load step may be longer than the one before. It is as long where that began a fifth of the forces away
    /// from equilibrium, or its second iteration a thousandth.
    pub load_step_growth: f64,
    /// Smallest load step before the solve gives up, relative to the load that was reached; above the first load step
    /// none is tried.
    pub least_load_step: f64,
    /// Unbalanced forces \[relative to loads and reactions\] and changes of volume \[relative to the body's\] of an
    /// equilibrium without a potential, where the accuracy of linear systems bounds what can be had. Minima of a
    /// potential have it on the way to another load, and go down to what rounding errors amount to in the end.
    pub accuracy: f64,
    /// The same without a potential on the way to another load, from where the next step starts and no more.
    pub accuracy_on_the_way: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            iterations: 600,
            iterations_per_load: 40,
            load_steps: LoadSteps::WhenNeeded,
            first_load_step: 0.25,
            load_step_growth: 2.0,
            least_load_step: 1e-4,
            accuracy: 1e-10,
            accuracy_on_the_way: 1e-2,
        }
    }
}
