//! The linear systems of Newton's method: by back-substitution for a body with a potential, else by GMRES
//! preconditioned by the factor.

use crate::SolveError;
use crate::elements::state::load_gradient;
use crate::elements::system::System;
use crate::linear::gmres::{LinearOutcome, gmres};

/// Residual of a linear system relative to its right-hand side: Newton's method stays quadratic down to it, and a step
/// that reaches equilibrium meets the accuracy in volume.
const TOLERANCE: f64 = 1e-10;
/// Most iterations of one linear system.
const MOST_ITERATIONS: usize = 400;

impl System<'_> {
    /// Factorises the stiffness that was assembled last: the shift of its diagonal [relative to the mean] and the number
    /// of its negative pivots, at least one of them where they are not counted. An indefinite one is shifted, without a count, if
    /// `definite`, or if its factorisation fails.
    pub(crate) fn factorise(&mut self, definite: bool) -> Option<(f64, usize)> {
        let (sparsity, matrix) = (&*self.sparsity, &mut self.assembly.matrix);
        if let Some(coupling) = &mut self.coupling {
            coupling.factorise(self.body)?;
        }
        if self.factor.positive_definite(sparsity, matrix) {
            return Some((0.0, 0));
        }
        if let Some(negative) =
            (!definite).then(|| self.factor.indefinite(sparsity, matrix)).flatten()
        {
            return Some((0.0, negative));
        }
        Some((self.factor.shifted(sparsity, matrix)?, 1))
    }

    /// Number of negative eigenvalues of the stiffness that was assembled last, and at least one where they cannot be counted; the factor
    /// is then that of [`System::factorise`] with `definite`.
    pub(crate) fn negative_eigenvalues(&mut self) -> usize {
        let (sparsity, matrix) = (&*self.sparsity, &mut self.assembly.matrix);
        if self.factor.positive_definite(sparsity, matrix) {
            return 0;
        }
        let negative = self.factor.indefinite(sparsity, matrix);
        self.factor.shifted(sparsity, matrix);
        negative.unwrap_or(1).max(1)
    }

    /// Solves for a change of the unknowns (free displacements, then pressures) by the whole derivative of the balance;
    /// `shift` is that of the factor. Also returns the outcome of the iteration; Newton steps may be inexact.
    pub(crate) fn solve(
        &self,
        mut right: Vec<f64>,
        shift: f64,
    ) -> Result<(Vec<f64>, LinearOutcome), SolveError> {
        if self.body.has_potential() && shift == 0.0 {
            self.factor.solve(&mut right);
            return Ok((right, LinearOutcome { iterations: 0, relative_residual: 0.0 }));
        }
        let free = self.sparsity.unknowns();
        let mut change = vec![0.0; right.len()];
        let precondition = |from: &[f64], to: &mut [f64]| {
            to.copy_from_slice(from);
            let (forces, pressures) = to.split_at_mut(free);
            if let Some(coupling) = &self.coupling {
                coupling.solve_schur(pressures);
                let mut full = vec![0.0; self.body.prescribed.len()];
                coupling.add_forces(self.body, pressures, &mut full);
                let gathered = self.sparsity.gather(&full);
                forces.iter_mut().zip(gathered).for_each(|(force, more)| *force -= more);
            }
            self.factor.solve(forces);
        };
        let apply = |from: &[f64], to: &mut [f64]| self.apply(from, to);
        let outcome = gmres(apply, precondition, &right, &mut change, TOLERANCE, MOST_ITERATIONS);
        let solved = change.iter().all(|c| c.is_finite());
        if solved { Ok((change, outcome)) } else { Err(SolveError::Singular) }
    }

    /// Adds `−K⁻¹ forces` to the free degrees of freedom, with the last factor.
    pub(crate) fn add_newton_step(&self, forces: &[f64], displacement: &mut [f64]) {
        let mut right: Vec<_> = self.sparsity.gather(forces).map(|f| -f).collect();
        self.factor.solve(&mut right);
        self.sparsity.scatter(right, displacement);
    }

    /// Derivative of the balance in the load factor.
    pub(crate) fn load_derivative(&self, displacement: &[f64], theta: &[f64]) -> Vec<f64> {
        let mut forces = load_gradient(self.body, displacement, theta);
        self.followers.add_forces(displacement, theta, &mut forces);
        let free = self.sparsity.gather(&forces);
        free.chain(std::iter::repeat_n(0.0, self.pressures())).collect()
    }
}
