//! Cholesky factors of the stiffness matrix, with one symbolic analysis for all.

use crate::SolveError;
use crate::sparsity::Sparsity;
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::{Conj, MatMut, Par, Side};
use std::sync::Arc;

/// First shift \[relative to the mean diagonal\] that is tried on an indefinite matrix, and its growth.
/// Small enough to keep a nearly definite matrix's Newton step, and reaching any matrix in a few tries.
const FIRST_SHIFT: f64 = 1e-4;
const SHIFT_GROWTH: f64 = 8.0;
const MOST_SHIFTS: usize = 12;

/// A symbolic analysis and room for the numbers of one factor.
pub(crate) struct Factor {
    symbolic: Arc<SymbolicCholesky<usize>>,
    values: Vec<f64>,
    memory: MemBuffer,
    kind: Kind,
}

/// What the values of a factor are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Llt,
    Ldlt,
}

impl Factor {
    pub fn new(sparsity: &Sparsity) -> Result<Self, SolveError> {
        // Supernodal always: a whole solve of the beam (1080 unknowns) takes 9.8 ms with it, 25.5 ms with
        // the simplicial kernel, and larger bodies gain more.
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        // Without a reordering faer 0.24 reads the upper half whatever the side.
        let upper = sparsity.upper();
        let ordering = SymmetricOrdering::Identity;
        let symbolic =
            factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, ordering, parameters)
                .map_err(|_| SolveError::OutOfMemory { unknowns: sparsity.unknowns() })?;
        Self::with_symbolic(Arc::new(symbolic))
    }

    /// Another factor of the same sparsity: its own numbers, the same analysis.
    pub fn fresh(&self) -> Result<Self, SolveError> {
        Self::with_symbolic(self.symbolic.clone())
    }

    fn with_symbolic(symbolic: Arc<SymbolicCholesky<usize>>) -> Result<Self, SolveError> {
        let par = Par::Seq;
        let needed = StackReq::any_of(&[
            symbolic.factorize_numeric_llt_scratch::<f64>(par, Default::default()),
            symbolic.factorize_numeric_ldlt_scratch::<f64>(par, Default::default()),
            symbolic.solve_in_place_scratch::<f64>(1, par),
        ]);
        let memory = MemBuffer::try_new(needed)
            .map_err(|_| SolveError::OutOfMemory { unknowns: symbolic.nrows() })?;
        let values = vec![0.0; symbolic.len_val()];
        Ok(Self { symbolic, values, memory, kind: Kind::Llt })
    }

    /// Number of stored entries of the factor.
    pub fn entries(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Factorises `L Lᵀ`; false where the matrix is not positive definite.
    pub fn positive_definite(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> bool {
        self.kind = Kind::Llt;
        if self.symbolic.nrows() == 0 {
            return true;
        }
        self.symbolic
            .factorize_numeric_llt(
                &mut self.values,
                SparseColMatRef::new(sparsity.pattern.as_ref(), &matrix[..sparsity.entries()]),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Default::default(),
            )
            .is_ok()
    }

    /// Factorises `L D Lᵀ` and counts the negative pivots: the number of negative eigenvalues by
    /// Sylvester's law of inertia. `None` where a pivot vanishes.
    pub fn indefinite(&mut self, sparsity: &Sparsity, matrix: &[f64]) -> Option<usize> {
        self.kind = Kind::Ldlt;
        self.symbolic
            .factorize_numeric_ldlt(
                &mut self.values,
                SparseColMatRef::new(sparsity.pattern.as_ref(), &matrix[..sparsity.entries()]),
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Default::default(),
            )
            .ok()?;
        let pivots = self.pivots()?;
        pivots.iter().all(|d| d.is_finite()).then(|| pivots.iter().filter(|&&d| d < 0.0).count())
    }

    fn pivots(&self) -> Option<Vec<f64>> {
        let SymbolicCholeskyRaw::Supernodal(symbolic) = self.symbolic.raw() else { return None };
        let factor =
            faer::sparse::linalg::cholesky::supernodal::SupernodalLdltRef::<usize, f64>::new(
                symbolic,
                &self.values,
            );
        let blocks = (0..symbolic.n_supernodes()).map(|s| factor.supernode(s).val());
        Some(blocks.flat_map(|block| (0..block.ncols()).map(move |i| block[(i, i)])).collect())
    }

    /// Factorises the matrix plus the least multiple of its mean diagonal that was found to make it
    /// positive definite; returns the multiple. The diagonal in `matrix` is restored.
    pub fn shifted(&mut self, sparsity: &Sparsity, matrix: &mut [f64]) -> Option<f64> {
        let diagonal = &sparsity.pattern.col_ptr()[..sparsity.unknowns()];
        let original: Vec<_> = diagonal.iter().map(|&slot| matrix[slot]).collect();
        let mean = original.iter().map(|d| d.abs()).sum::<f64>() / original.len() as f64;
        let mut shift = FIRST_SHIFT;
        let mut found = None;
        for _ in 0..MOST_SHIFTS {
            for (&slot, d) in diagonal.iter().zip(&original) {
                matrix[slot] = d + shift * mean;
            }
            if self.positive_definite(sparsity, matrix) {
                found = Some(shift);
                break;
            }
            shift *= SHIFT_GROWTH;
        }
        diagonal.iter().zip(&original).for_each(|(&slot, &d)| matrix[slot] = d);
        found
    }

    /// Overwrites a right-hand side with the solution of the last factorised system.
    pub fn solve(&mut self, right: &mut [f64]) {
        if right.is_empty() {
            return;
        }
        let stack = MemStack::new(&mut self.memory);
        let rows = right.len();
        let right = MatMut::from_column_major_slice_mut(right, rows, 1);
        let (symbolic, values) = (&*self.symbolic, &self.values[..]);
        match self.kind {
            Kind::Llt => LltRef::new(symbolic, values).solve_in_place_with_conj(
                Conj::No,
                right,
                Par::Seq,
                stack,
            ),
            Kind::Ldlt => LdltRef::new(symbolic, values).solve_in_place_with_conj(
                Conj::No,
                right,
                Par::Seq,
                stack,
            ),
        }
    }
}
