//! Result of a solve.

use crate::History;
use crate::elements::System;
use crate::solve::Equilibrium;
use sinew_energy::metrics::mean_and_largest;
use std::time::Instant;

/// An equilibrium of a body.
///
/// Where there is no potential ([`Solution::has_potential`]), `energy` leaves out loose followers and the field of pressure.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Displacement `[u_x, u_y, u_z]` node by node \[length\].
    pub displacement: Vec<f64>,
    /// The field of pressure at [`sinew_energy::PressureField::nodes`] \[stress\], compression negative; empty without one.
    pub pressure: Vec<f64>,
    /// Total potential energy \[stress·length³\].
    pub energy: f64,
    /// Whether the equilibrium is a stationary point of that energy.
    pub has_potential: bool,
    /// Parameters of law and loads.
    pub theta: Vec<f64>,
    /// Fraction of all loads and prescribed motions; 1 except along a [`crate::Curve`].
    pub load_factor: f64,
    /// Norm of the unbalanced nodal forces \[stress·length²\].
    pub residual: f64,
    /// Error that the iteration leaves: mean nodal length of the Newton step that would follow \[length\]; `None` without a potential, or where conjugate gradients do not tell it.
    pub iteration_error: Option<f64>,
    /// Norm of the residual of the volume constraint \[length³\].
    pub volume_residual: f64,
    /// Norm of the loads and reactions \[stress·length²\], to compare the residual with.
    pub force_scale: f64,
    /// Least volume ratio J of all cells.
    pub least_volume_ratio: f64,
    /// Number of negative eigenvalues of the symmetric part of the last stiffness of the displacements: 0 for a stable equilibrium of a potential.
    pub negative_pivots: usize,
    /// Whether a factor counted them. Where it would take more than 1 GB, 0 says that conjugate gradients met no negative curvature.
    pub counted: bool,
    /// Number of load steps, 1 if the whole load was applied at once; includes those of the softer bodies that lead to
    /// a nearly incompressible one.
    pub load_steps: usize,
    /// Whether the search met an indefinite stiffness. By load steps, the body has snapped to another branch of
    /// equilibria. Otherwise the search may have passed the equilibrium of a rising load: see
    /// [`crate::Solver::under_rising_load`].
    pub jumped: bool,
    /// Iterations of all linear systems; 0 where factors solve them.
    pub linear_iterations: usize,
    /// All iterations.
    pub history: History,
    /// Wall-clock time of the solve \[s\].
    pub seconds: f64,
}

impl Solution {
    /// Solution of the equilibrium found last.
    pub(crate) fn new(
        system: &System<'_>,
        (found, load_steps): (Equilibrium, usize),
        theta: &[f64],
        history: History,
        start: Instant,
    ) -> Self {
        let iteration_error = system.body.has_potential().then(|| {
            let mut next = vec![0.0; found.unknowns.displacement.len()];
            system.add_newton_step(&system.assembly.gradient, &mut next);
            mean_and_largest(&next)[0]
        });
        let iteration_error = iteration_error.filter(|error| error.is_finite());
        Self {
            displacement: found.unknowns.displacement,
            pressure: found.unknowns.pressure,
            // The sum over all cells in one order, the same as every reader of the potential gets.
            energy: system.assembly.energy,
            has_potential: system.body.has_potential(),
            theta: theta.to_vec(),
            load_factor: found.load_factor,
            residual: found.residual.force,
            iteration_error,
            volume_residual: found.residual.volume,
            force_scale: system.assembly.force_scale,
            least_volume_ratio: system.assembly.least_volume_ratio,
            negative_pivots: found.negative_pivots,
            counted: !system.iterates,
            load_steps,
            jumped: found.jumped,
            linear_iterations: found.linear_iterations,
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
