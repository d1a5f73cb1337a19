//! Single steps of Newton's method from a predicted displacement: its distance to equilibrium and its correction.

use crate::elements::{PredictedStress, check_potential, inadmissible, place};
use crate::linear::systems::TOLERANCE;
use crate::linear::{dot, norm};
use crate::solve::SUFFICIENT;
use crate::{Result, SolveError, Solver};
use std::time::Instant;

/// Shorter steps correct nothing.
const SHORTEST_STEP: f64 = 1.0 / 64.0;

/// One step of Newton's method.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonStep {
    /// Displacement after the step \[length\].
    pub displacement: Vec<f64>,
    /// Energy norm `‖K⁻¹r‖_K = √(rᵀK⁻¹r)` of the whole step [√(stress·length³)], with residual r and stiffness K where it
    /// started: an estimate of the error there that becomes exact as the error becomes small.
    pub energy_norm: f64,
    /// Norm of the unbalanced nodal forces before the step \[stress·length²\].
    pub residual_before: f64,
    /// Norm of the unbalanced nodal forces after the step \[stress·length²\].
    pub residual_after: f64,
    /// Norm of loads and reactions \[stress·length²\], to compare residuals with.
    pub force_scale: f64,
    /// Total potential energy before the step \[stress·length³\].
    pub energy_before: f64,
    /// Total potential energy after the step \[stress·length³\].
    pub energy_after: f64,
    /// Part of the whole step that was taken: shorter ones keep cells from inverting and lower the energy; 0 when
    /// none does, and the displacement is the one that was given.
    pub length: f64,
    /// Multiple of the mean diagonal that made the stiffness positive definite; 0 when it was.
    pub shift: f64,
    /// Wall-clock time \[s\].
    pub seconds: f64,
}

impl Solver<'_> {
    /// At most `count` steps of Newton's method from a displacement \[length\] near equilibrium, each from where the one before ended; fewer when
    /// one of length 0 ends them. Prescribed components are put in their places first.
    ///
    /// From the second step on the geometric stiffness is built from the stress that the step before foresaw, as in
    /// [`Solver::solve`].
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, [`SolveError::Inadmissible`] where the displacement inverts a
    /// cell, [`SolveError::Singular`].
    pub fn newton_steps(
        &mut self,
        displacement: &[f64],
        theta: &[f64],
        count: usize,
    ) -> Result<Vec<NewtonStep>> {
        let from = self.placed(displacement, theta)?;
        let (mut predicted, mut steps) = (None, Vec::<NewtonStep>::new());
        while steps.len() < count && steps.last().is_none_or(|step| step.length > 0.0) {
            let from = steps.last().map_or(&from, |step| &step.displacement);
            steps.push(self.step_from(from, theta, &mut predicted)?);
        }
        Ok(steps)
    }

    /// A displacement of this body with prescribed components in their places.
    pub(crate) fn placed(&self, displacement: &[f64], theta: &[f64]) -> Result<Vec<f64>> {
        check_potential(self.body(), displacement, theta)?;
        let mut placed = displacement.to_vec();
        place(self.body(), 1.0, &mut placed);
        Ok(placed)
    }

    /// Displacement \[length\] after a whole step with the stiffness that was factorised last, by [`Solver::newton_steps`] or
    /// [`Solver::sensitivity_at`]: one gradient and one back-substitution, where the two states are near to each other.
    ///
    /// # Errors
    /// θ or a displacement that does not belong to the body, [`SolveError::Inadmissible`] where it inverts a cell, or
    /// [`SolveError::Singular`] where nothing was factorised.
    pub fn simplified_step(&mut self, displacement: &[f64], theta: &[f64]) -> Result<Vec<f64>> {
        let (mut moved, mut forces) =
            (self.placed(displacement, theta)?, vec![0.0; displacement.len()]);
        if !self.body().value_and_gradient(&moved, theta, &mut forces).is_finite() {
            return Err(inadmissible(self.body(), &moved));
        }
        self.system.add_newton_step(&forces, &mut moved);
        // A factor that was never computed solves nothing.
        if moved.iter().all(|u| u.is_finite()) { Ok(moved) } else { Err(SolveError::Singular) }
    }

    /// Displacement \[length\] of the linearised body under all loads and prescribed motions at θ: one linear system with
    /// the stiffness of the unloaded body at rest. The scale of displacements and energies that training without
    /// simulations starts from.
    ///
    /// # Errors
    /// θ that makes no sense, or [`SolveError::Singular`].
    pub fn linear_response(&mut self, theta: &[f64]) -> Result<Vec<f64>> {
        self.body().check_theta(theta)?;
        self.system.linear_response(theta, TOLERANCE)
    }

    /// Energy norm `√(eᵀ K e)` of a difference of displacements \[length\], with the stiffness K at `displacement`
    /// [√(stress·length³)].
    ///
    /// # Errors
    /// θ or displacements that do not belong to the body, or [`SolveError::Inadmissible`].
    pub fn energy_norm(
        &mut self,
        displacement: &[f64],
        theta: &[f64],
        difference: &[f64],
    ) -> Result<f64> {
        let forces = self.stiffness_times(displacement, theta, difference)?;
        Ok(dot(&forces, difference).max(0.0).sqrt())
    }

    pub(crate) fn step_from(
        &mut self,
        from: &[f64],
        theta: &[f64],
        predicted: &mut Option<PredictedStress>,
    ) -> Result<NewtonStep> {
        let start = Instant::now();
        self.visit(from, (theta, 1.0), predicted.as_ref())?;
        let (shift, _) = self.system.factorise(true).ok_or(SolveError::Singular)?;
        let assembly = &self.system.assembly;
        let (energy_before, force_scale) = (assembly.energy, assembly.force_scale);
        let gradient = &assembly.gradient;
        let residual_before = self.norm_of_free(gradient);
        let direction = self.system.newton_step(gradient);
        let promised = -dot(gradient, &direction);
        if !promised.is_finite() {
            return Err(SolveError::Singular);
        }
        let mut step = NewtonStep {
            displacement: from.to_vec(),
            energy_norm: promised.max(0.0).sqrt(),
            residual_before,
            residual_after: residual_before,
            force_scale,
            energy_before,
            energy_after: energy_before,
            length: 0.0,
            shift,
            seconds: 0.0,
        };
        self.search(&mut step, theta, &direction, promised);
        let taken: Vec<f64> = direction.iter().map(|d| step.length * d).collect();
        *predicted = self.system.predict_stress(&taken);
        step.seconds = start.elapsed().as_secs_f64();
        Ok(step)
    }

    /// Takes the longest of the steps 1, ½, ¼, … that inverts no cell and lowers the energy, or the residual if the
    /// energy change is within rounding error.
    fn search(&self, step: &mut NewtonStep, theta: &[f64], direction: &[f64], promised: f64) {
        let from = step.displacement.clone();
        let mut gradient = vec![0.0; from.len()];
        let mut length = 1.0;
        while length >= SHORTEST_STEP {
            let trial: Vec<f64> = from.iter().zip(direction).map(|(u, d)| u + length * d).collect();
            let energy = self.body().value_and_gradient(&trial, theta, &mut gradient);
            let residual = self.norm_of_free(&gradient);
            let lower = energy <= step.energy_before - SUFFICIENT * length * promised;
            let hidden = length * promised <= self.system.assembly.energy_noise;
            let better = lower || (hidden && residual <= step.residual_before);
            if energy.is_finite() && better && !self.system.passes_flat(theta, direction, length) {
                step.displacement = trial;
                (step.energy_after, step.residual_after) = (energy, residual);
                step.length = length;
                return;
            }
            length *= 0.5;
        }
    }

    /// Norm of the free components of nodal forces.
    pub(crate) fn norm_of_free(&self, gradient: &[f64]) -> f64 {
        norm(&self.system.sparsity.gather(gradient).collect::<Vec<_>>())
    }
}
