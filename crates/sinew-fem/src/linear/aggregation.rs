//! Conjugate gradients preconditioned by smoothed aggregation: memory grows with the body, not with the fill of a factor.

mod blocks;
mod multigrid;
mod pattern;

use crate::linear::{End, Iterated, Sparsity, conjugate_gradients, shift_of};
use blocks::BlockMatrix;
use multigrid::Multigrid;
use pattern::Pattern;
use std::sync::Arc;

/// Most iterations of one linear system: a factor is cheaper beyond.
pub(crate) const MOST_ITERATIONS: usize = 400;

/// Most iterations with the hierarchy of another matrix \[per digit\]. A new one takes as long as twenty.
const STALE: f64 = 30.0;
/// Number of the least shift, 5e-4: smaller ones cost compact bodies trials, and save no steps.
const LEAST_SHIFT: usize = 4;
/// Shifts from one hierarchy to the next where an indefinite matrix has none.
const REBUILD: usize = 3;

/// A sparsity, and the entries of the lower half of a matrix.
pub(crate) type Matrix<'m> = (&'m Sparsity, &'m [f64]);
/// Solution of a linear system, and the shift of its matrix; `None` where none was found.
pub(crate) type Shifted = Option<(Vec<f64>, f64)>;

/// Solves systems with a matrix plus a multiple of its mean diagonal by conjugate gradients.
#[derive(Default)]
pub(crate) struct Aggregation {
    pattern: Option<Arc<Pattern>>,
    /// The last matrix over its mean diagonal, plus the shift.
    blocks: Option<BlockMatrix<f64, 3, 3>>,
    hierarchy: Option<Multigrid>,
    /// Number of the shift of the last matrix, 0 without one.
    shift: usize,
    /// Mean diagonal of the last matrix.
    mean: f64,
    /// Iterations of all systems.
    pub iterations: usize,
}

impl Aggregation {
    /// Another one for the same sparsity.
    pub(crate) fn fresh(&self) -> Self {
        Self { pattern: self.pattern.clone(), ..Self::default() }
    }

    /// Frees the hierarchy, and forgets earlier matrices.
    pub(crate) fn clear(&mut self) {
        *self = self.fresh();
    }

    /// Frees matrix and hierarchy.
    pub(crate) fn drop_hierarchy(&mut self) {
        (self.blocks, self.hierarchy) = (None, None);
    }

    /// Solves with a matrix plus the least of `shifts` tried for which conjugate gradients meet no negative curvature: the solution and the
    /// shift [relative to the mean diagonal]. `None` where there is none, or they do not converge.
    ///
    /// Trials begin without a shift and go on one below the last one. A hierarchy that is present is that of an earlier matrix; it serves all trials unless they take too long.
    /// `positions` are those of the deformed body.
    pub(crate) fn solve_shifted(
        &mut self,
        matrix: Matrix<'_>,
        positions: &[f64],
        right: &[f64],
        tolerance: f64,
        shifts: usize,
    ) -> Shifted {
        self.mean = matrix.0.mean_diagonal(matrix.1);
        let (first, mut matching) = (self.shift.saturating_sub(1).max(LEAST_SHIFT), false);
        self.shift = 0;
        loop {
            if self.shift >= shifts {
                return None;
            }
            if self.hierarchy.is_none() {
                let number = self.build(matrix, positions, shifts)?;
                matching = number == self.shift;
            }
            if !matching {
                self.load(matrix, self.shift);
            }
            let stale = (-STALE * tolerance.log10()) as usize;
            let most = if matching { MOST_ITERATIONS } else { stale.min(MOST_ITERATIONS) };
            let (solution, iterations, end) = self.solve(right, tolerance, most);
            self.iterations += iterations;
            match end {
                End::Converged => return Some((solution, shift_of(self.shift))),
                End::NegativeCurvature => {
                    (self.shift, matching) = (first.max(self.shift + 1), false)
                }
                End::Failed if matching => return None,
                End::Failed => self.hierarchy = None,
            }
        }
    }

    /// Takes a matrix, with a shift of this number.
    fn load(&mut self, (sparsity, entries): Matrix<'_>, number: usize) -> &Pattern {
        let pattern = self.pattern.get_or_insert_with(|| Arc::new(Pattern::new(sparsity)));
        let blocks = self.blocks.get_or_insert_with(|| pattern.empty());
        pattern.load(entries, shift_of(number), self.mean, blocks);
        pattern
    }

    /// Builds a hierarchy with the present shift, or the first of growing ones that allows it; returns the number of that one. Smaller shifts leave the
    /// matrix indefinite.
    fn build(&mut self, matrix: Matrix<'_>, positions: &[f64], shifts: usize) -> Option<usize> {
        let mut number = self.shift;
        while number < shifts {
            let modes = self.load(matrix, number).rigid_modes(matrix.0, positions);
            self.hierarchy = Multigrid::new(self.blocks.as_ref()?, &modes);
            if self.hierarchy.is_some() {
                return Some(number);
            }
            self.shift = number + 1;
            number += REBUILD;
        }
        None
    }

    /// Solves with the last matrix, shift and hierarchy to a residual of `tolerance` times the right-hand side.
    pub(crate) fn solve(&self, right: &[f64], tolerance: f64, most: usize) -> Iterated {
        let Self {
            hierarchy: Some(hierarchy), pattern: Some(pattern), blocks: Some(blocks), ..
        } = self
        else {
            return (vec![f64::NAN; right.len()], 0, End::Failed);
        };
        let apply = |from: &[f64], to: &mut [f64]| {
            blocks.multiply(from.as_chunks().0, to.as_chunks_mut().0);
        };
        let precondition = hierarchy.preconditioner();
        // Matrix and right-hand side are over the mean diagonal.
        let right = pattern.scattered(right, self.mean);
        let (solution, iterations, end) =
            conjugate_gradients(apply, precondition, &right, tolerance, most);
        (pattern.gathered(&solution), iterations, end)
    }

    /// Multiplies a vector by an approximation of the inverse of the last matrix, a V-cycle; NaN without a hierarchy.
    pub(crate) fn cycle(&self) -> impl FnMut(&mut [f64]) + '_ {
        let hierarchy = self.hierarchy.as_ref().map(Multigrid::preconditioner);
        let mut parts = self.pattern.as_ref().zip(hierarchy);
        move |vector| match &mut parts {
            Some((pattern, precondition)) => {
                let right = pattern.scattered(vector, self.mean);
                let mut solution = right.clone();
                precondition(&right, &mut solution);
                vector.copy_from_slice(&pattern.gathered(&solution));
            }
            None => vector.fill(f64::NAN),
        }
    }
}
