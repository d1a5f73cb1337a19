//! Sparse Cholesky factorisation by faer, in single and double precision.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::{SymbolicCholesky, SymbolicCholeskyRaw};
use faer::traits::RealField;
use faer::{MatMut, Par, Side};
use std::num::NonZeroUsize;
use std::ops::Range;

/// Shares of the dense blocks of a large factor. The division is fixed, so that results do not depend on the number of
/// threads; a single thread does not divide, with the same bits.
const SHARES: NonZeroUsize = NonZeroUsize::new(4).unwrap();
/// Least number of entries of a factor whose blocks are divided.
pub(super) const LARGE: usize = 2_000_000;

/// Overwrites a right-hand side by a factor's `solve`, with its memory.
pub(super) fn back_substitute<T: RealField>(
    symbolic: &SymbolicCholesky<usize>,
    right: &mut [T],
    solve: impl FnOnce(MatMut<'_, T>, &mut MemStack),
) {
    let size = right.len();
    let right = MatMut::from_column_major_slice_mut(right, size, 1);
    let mut memory = MemBuffer::new(symbolic.solve_in_place_scratch::<T>(1, Par::Seq));
    solve(right, MemStack::new(&mut memory));
}

/// Factorises `L Lᵀ` of a matrix with this lower half; false where that fails.
pub(super) fn cholesky<T: RealField + Default>(
    symbolic: &SymbolicCholesky<usize>,
    entries: &mut Vec<T>,
    half: SparseColMatRef<'_, usize, T>,
) -> bool {
    let scratch = symbolic.factorize_numeric_llt_scratch::<T>(shares(symbolic), Default::default());
    let Some(mut memory) = prepared(symbolic, entries, scratch) else { return false };
    let regularisation = LltRegularization::default();
    let (par, memory) = (shares(symbolic), MemStack::new(&mut memory));
    symbolic
        .factorize_numeric_llt(
            entries,
            half,
            Side::Lower,
            regularisation,
            par,
            memory,
            Default::default(),
        )
        .is_ok()
}

/// Room for the entries of a factor, and memory to compute it in; `None` where they do not fit.
pub(super) fn prepared<T: Clone + Default>(
    symbolic: &SymbolicCholesky<usize>,
    entries: &mut Vec<T>,
    scratch: StackReq,
) -> Option<MemBuffer> {
    entries.try_reserve_exact(symbolic.len_val() - entries.len()).ok()?;
    entries.resize(symbolic.len_val(), T::default());
    MemBuffer::try_new(scratch).ok()
}

/// Columns that are eliminated together, with the rows of their common block below them, ascending.
pub(super) fn supernodes(symbolic: &SymbolicCholesky<usize>) -> Vec<(Range<usize>, &[usize])> {
    match symbolic.raw() {
        SymbolicCholeskyRaw::Supernodal(symbolic) => {
            let own = symbolic.supernode_begin().iter().zip(symbolic.supernode_end());
            let below = (0..).map(|s| symbolic.supernode(s).pattern());
            own.map(|(&begin, &end)| begin..end).zip(below).collect()
        }
        // Tiny matrices have no supernodes, whatever is requested; the diagonal comes first in each column.
        SymbolicCholeskyRaw::Simplicial(symbolic) => {
            let columns = symbolic.col_ptr().windows(2).zip(0..);
            let below = |ends: &[usize]| &symbolic.row_idx()[ends[0] + 1..ends[1]];
            columns.map(|(ends, column)| (column..column + 1, below(ends))).collect()
        }
    }
}

/// Slots of the diagonal of a factor.
pub(super) fn pivots(symbolic: &SymbolicCholesky<usize>) -> impl Iterator<Item = usize> {
    let mut next = 0;
    supernodes(symbolic).into_iter().flat_map(move |(own, below)| {
        let (start, rows) = (next, own.len() + below.len());
        next += own.len() * rows;
        (0..own.len()).map(move |i| start + i * (rows + 1))
    })
}

/// Division of a factor's blocks.
fn shares(symbolic: &SymbolicCholesky<usize>) -> Par {
    let alone = rayon::current_num_threads() == 1;
    if alone || symbolic.len_val() < LARGE { Par::Seq } else { Par::Rayon(SHARES) }
}
