//! The stiffness matrix for other uses: vibrations, preconditioners, tests.

use crate::elements::check::check_displacement;
use crate::elements::state::State;
use crate::elements::system::System;
use crate::{Solution, SolveError, Solver};

/// The stiffness of the free degrees of freedom at an equilibrium, its lower half by entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Stiffness {
    /// Degree of freedom `3 × node + component` of each row and column; along the axes of the node's frame, if
    /// [`sinew_energy::BodyArrays::frames`] has one.
    pub degree_of_freedom: Vec<usize>,
    /// Rows of the entries; column by column.
    pub rows: Vec<usize>,
    /// Start of each column in the entries, and their number.
    pub column_starts: Vec<usize>,
    /// The entries \[stress·length\].
    pub values: Vec<f64>,
}

impl Solver<'_> {
    /// Second derivative of the potential at a solution.
    ///
    /// # Errors
    /// A solution of another body, or [`SolveError::Inadmissible`].
    pub fn stiffness(&mut self, solution: &Solution) -> Result<Stiffness, SolveError> {
        let Solution { displacement, theta, load_factor, .. } = solution;
        self.visit(displacement, (theta, *load_factor), None)?;
        let System { sparsity, assembly, .. } = &self.system;
        Ok(Stiffness {
            degree_of_freedom: sparsity.degree_of_freedom.clone(),
            rows: sparsity.pattern.row_idx().to_vec(),
            column_starts: sparsity.pattern.col_ptr().to_vec(),
            values: assembly.matrix[..sparsity.entries()].to_vec(),
        })
    }

    /// Second derivative of the potential at a displacement times a direction, over all degrees of freedom.
    ///
    /// # Errors
    /// θ or vectors that do not belong to the body, or an energy that is not finite there.
    pub fn stiffness_times(
        &mut self,
        displacement: &[f64],
        theta: &[f64],
        direction: &[f64],
    ) -> Result<Vec<f64>, SolveError> {
        check_displacement(self.body(), direction)?;
        self.visit(displacement, (theta, 1.0), None)?;
        let state = State { displacement, theta, load_factor: 1.0, pressure: &[] };
        let mut forces = vec![0.0; displacement.len()];
        self.system.assembly.add_stiffness_times(self.body(), state, direction, &mut forces);
        Ok(forces)
    }
}
