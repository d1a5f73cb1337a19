//! Cholesky factors of the stiffness matrix, with one symbolic analysis for all.

use crate::SolveError;
use crate::linear::cholesky::Cholesky;
use crate::sparsity::Sparsity;

/// First shift \[relative to the mean diagonal\] that is tried on an indefinite matrix, and its growth.
/// Small enough to keep a nearly definite matrix's Newton step, and reaching any matrix in a few tries.
const FIRST_SHIFT: f64 = 1e-4;
const SHIFT_GROWTH: f64 = 8.0;
const MOST_SHIFTS: usize = 12;

/// The Cholesky factor of a body's stiffness.
pub(crate) struct Factor(Cholesky);

impl Factor {
    /// Analyses a sparsity.
    pub fn new(sparsity: &Sparsity) -> Result<Self, SolveError> {
        let memory = || SolveError::OutOfMemory { unknowns: sparsity.unknowns() };
        let pattern = &sparsity.pattern;
        Cholesky::new(pattern.col_ptr(), pattern.row_idx()).map(Self).ok_or_else(memory)
    }

    /// Another factor of the same sparsity: its own numbers, the same analysis.
    pub fn fresh(&self) -> Result<Self, SolveError> {
        let memory = || SolveError::OutOfMemory { unknowns: self.0.unknowns() };
        self.0.fresh().map(Self).ok_or_else(memory)
    }

    /// Number of stored entries of the factor.
    pub fn entries(&self) -> usize {
        self.0.entries()
    }

    /// Factorises `L Lᵀ`; false where the matrix is not positive definite.
    pub fn positive_definite(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> bool {
        self.0.factorise(&matrix[..sparsity.entries()])
    }

    /// Factorises `L D Lᵀ` and counts the negative pivots: the number of negative eigenvalues by
    /// Sylvester's law of inertia. `None` where a pivot vanishes.
    pub fn indefinite(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> Option<usize> {
        self.0.factorise_indefinite(&matrix[..sparsity.entries()])
    }

    /// Factorises the matrix plus the least multiple of its mean diagonal that was found to make it
    /// positive definite; returns the multiple. The diagonal in `matrix` is restored.
    pub fn shifted(&mut self, sparsity: &Sparsity, matrix: &mut [f64]) -> Option<f64> {
        least_shift(sparsity, matrix, 0.0, |matrix| self.positive_definite(sparsity, matrix))
    }

    /// Overwrites a right-hand side with the solution of the last factorised system.
    pub fn solve(&mut self, right: &mut [f64]) {
        self.0.solve(right);
    }
}

/// Adds growing multiples, above `above`, of a matrix' mean diagonal to its diagonal until `accept` finds it
/// positive definite; returns the multiple. The diagonal in `matrix` is restored.
pub(crate) fn least_shift(
    sparsity: &Sparsity,
    matrix: &mut [f64],
    above: f64,
    mut accept: impl FnMut(&[f64]) -> bool,
) -> Option<f64> {
    let diagonal = &sparsity.pattern.col_ptr()[..sparsity.unknowns()];
    let original: Vec<_> = diagonal.iter().map(|&slot| matrix[slot]).collect();
    let mean = original.iter().map(|d| d.abs()).sum::<f64>() / original.len() as f64;
    let shifts = (0..MOST_SHIFTS).map(|i| FIRST_SHIFT * SHIFT_GROWTH.powi(i as i32));
    let found = shifts.filter(|&shift| shift > above).find(|shift| {
        for (&slot, d) in diagonal.iter().zip(&original) {
            matrix[slot] = d + shift * mean;
        }
        accept(matrix)
    });
    diagonal.iter().zip(&original).for_each(|(&slot, &d)| matrix[slot] = d);
    found
}
