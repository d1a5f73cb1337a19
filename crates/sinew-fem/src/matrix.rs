//! The stiffness matrix for other uses: vibrations, preconditioners, tests.

use crate::state::State;
use crate::{Solution, SolveError, Solver};

/// The stiffness of the free degrees of freedom at an equilibrium, its lower half by entries.
#[derive(Clone, Debug, PartialEq)]
pub struct Stiffness {
    /// Degree of freedom `3 × node + component` of each row and column; along the axes of the node's frame, if
    /// [`sinew_energy::Body::frames`] has one.
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
    /// A solution of another body.
    pub fn stiffness(&mut self, solution: &Solution) -> Result<Stiffness, SolveError> {
        self.check_solution(solution)?;
        let Solution { displacement, theta, .. } = solution;
        let state = State { displacement, theta, load_factor: 1.0, pressure: &[] };
        self.assembly.assemble(self.potential, &self.sparsity, state, None);
        Ok(Stiffness {
            degree_of_freedom: self.sparsity.degree_of_freedom.clone(),
            rows: self.sparsity.pattern.row_idx().to_vec(),
            column_starts: self.sparsity.pattern.col_ptr().to_vec(),
            values: self.assembly.matrix[..self.sparsity.entries()].to_vec(),
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
        self.potential.check_theta(theta)?;
        self.check_displacement(displacement)?;
        self.check_displacement(direction)?;
        let state = State { displacement, theta, load_factor: 1.0, pressure: &[] };
        self.assembly.assemble(self.potential, &self.sparsity, state, None);
        if !self.assembly.is_finite() {
            return Err(SolveError::Inadmissible { cell: self.assembly.worst_cell });
        }
        let mut forces = vec![0.0; displacement.len()];
        self.assembly.add_stiffness_times(self.potential, state, direction, &mut forces);
        Ok(forces)
    }
}
