//! How an equilibrium moves with θ.

use crate::linear_solver::Solved;
use crate::state::State;
use crate::vector::dot;
use crate::{Solution, SolveError, Solver};
use sinew_energy::{Body, Magnitude};
use sinew_num::Mat3;

/// Residual of the linear systems relative to their right-hand sides, where they are solved by iteration.
const ACCURACY: f64 = 1e-10;

impl Solver<'_> {
    /// Derivative of the displacement in each entry of θ: one vector like the displacement per entry.
    ///
    /// The implicit function theorem `K ∂u/∂θ = −∂²Π/∂u∂θ`, with exact derivatives throughout and one
    /// factorisation for all entries.
    ///
    /// # Errors
    /// A solution of another body, [`SolveError::Singular`], or [`SolveError::Inadmissible`] where derivatives overflow.
    pub fn sensitivity(&mut self, solution: &Solution) -> Result<Vec<Vec<f64>>, SolveError> {
        self.sensitivity_at(&solution.displacement, &solution.theta)
    }

    /// The same at a displacement \[length\] near to an equilibrium, as if it were one.
    ///
    /// # Errors
    /// As [`Solver::sensitivity`].
    pub fn sensitivity_at(
        &mut self,
        displacement: &[f64],
        theta: &[f64],
    ) -> Result<Vec<Vec<f64>>, SolveError> {
        self.factorise_at(displacement, theta)?;
        let column = |index: usize| {
            let forces = force_change(self.potential, displacement, theta, &unit(theta, index));
            let mut change = vec![0.0; displacement.len()];
            self.add_exactly(&forces, &mut change)?;
            self.finite(change)
        };
        (0..theta.len()).map(column).collect()
    }

    /// Derivative in each entry of θ of a quantity of interest whose derivative in the displacement is
    /// `slope`: one linear system whatever the number of parameters (the adjoint method). What the quantity
    /// depends on θ directly is to be added.
    ///
    /// # Errors
    /// A solution of another body, a slope that does not fit it, or [`SolveError::Singular`].
    pub fn adjoint_sensitivity(
        &mut self,
        solution: &Solution,
        slope: &[f64],
    ) -> Result<Vec<f64>, SolveError> {
        self.check_displacement(slope)?;
        let Solution { displacement, theta, .. } = solution;
        self.factorise_at(displacement, theta)?;
        let mut adjoint = vec![0.0; displacement.len()];
        self.add_exactly(slope, &mut adjoint)?;
        let entry = |index: usize| {
            let forces = force_change(self.potential, displacement, theta, &unit(theta, index));
            dot(&forces, &adjoint)
        };
        self.finite((0..theta.len()).map(entry).collect())
    }

    /// Factorises the stiffness at a displacement.
    fn factorise_at(&mut self, displacement: &[f64], theta: &[f64]) -> Result<(), SolveError> {
        self.potential.check_theta(theta)?;
        self.check_displacement(displacement)?;
        let state = State { displacement, theta, load_factor: 1.0, pressure: &[] };
        self.assembly.assemble(self.potential, &self.sparsity, state, None);
        self.system.place(&self.potential.positions, displacement, &self.sparsity.frames);
        if !self.assembly.is_finite() {
            return Err(SolveError::Inadmissible { cell: self.assembly.worst_cell });
        }
        self.factorise_assembled()
    }

    /// Derivatives that do not overflow where the energy does not yet.
    fn finite(&self, slopes: Vec<f64>) -> Result<Vec<f64>, SolveError> {
        let cell = self.assembly.worst_cell;
        let finite = slopes.iter().all(|s| s.is_finite());
        if finite { Ok(slopes) } else { Err(SolveError::Inadmissible { cell }) }
    }

    fn factorise_assembled(&mut self) -> Result<(), SolveError> {
        if !self.system.positive_definite(&self.sparsity, &self.assembly.matrix) {
            if !self.system.is_certain() {
                self.system.factorise_instead(&self.sparsity)?;
            }
            let pivots = self.system.indefinite(&self.sparsity, &self.assembly.matrix);
            pivots.ok_or(SolveError::Singular)?;
        }
        Ok(())
    }

    /// Adds `−K⁻¹ forces` to the free degrees of freedom. Where iteration fails, the stiffness is factorised.
    fn add_exactly(&mut self, forces: &[f64], change: &mut [f64]) -> Result<(), SolveError> {
        if self.add_newton_step(forces, change, ACCURACY) != Solved::Done {
            self.system.factorise_instead(&self.sparsity)?;
            self.factorise_assembled()?;
            self.add_newton_step(forces, change, ACCURACY);
        }
        Ok(())
    }
}

/// The direction of one entry of θ.
fn unit(theta: &[f64], index: usize) -> Vec<f64> {
    (0..theta.len()).map(|i| f64::from(u8::from(i == index))).collect()
}

/// Change of the gradient of Π with θ along `direction`: `∂²Π/∂u∂θ · direction`.
fn force_change(
    potential: &Body,
    displacement: &[f64],
    theta: &[f64],
    direction: &[f64],
) -> Vec<f64> {
    let (parameters, rates) =
        (potential.law_parameters(theta), potential.law_parameters(direction));
    let mut forces = vec![0.0; displacement.len()];
    let stress_change =
        |point: usize, h: &Mat3<f64>| potential.material.stress_rate(point, parameters, rates, h);
    for points in &potential.patches {
        let Some(kinematics) = potential.patch_kinematics(points, displacement) else { continue };
        let volumes: Vec<_> = points.iter().map(|&point| potential.volumes[point]).collect();
        let at_points = points.iter().zip(&kinematics.scaled);
        let mut changes: Vec<_> = at_points.map(|(&point, h)| stress_change(point, h)).collect();
        kinematics.work_conjugate(&volumes, &mut changes);
        let at_points = points.iter().zip(&changes);
        at_points.for_each(|(&point, change)| potential.add_forces(point, change, &mut forces));
    }
    let alone = if potential.patches.is_empty() { potential.volumes.len() } else { 0 };
    for point in 0..alone {
        let h = potential.displacement_gradient(point, displacement);
        potential.add_forces(point, &stress_change(point, &h), &mut forces);
    }
    for surface in &potential.surfaces {
        if let Magnitude::Theta(_) = surface.magnitude {
            surface.value_and_add_gradient(displacement, direction, &mut forces);
        }
    }
    for pressure in &potential.pressures {
        if let Magnitude::Theta(_) = pressure.magnitude {
            // The load is linear in its size, so its change is the load of the size's change.
            pressure.value_and_add_gradient(displacement, direction, &mut forces);
        }
    }
    forces
}
