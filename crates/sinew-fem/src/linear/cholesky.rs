//! Sparse Cholesky factorisation by faer, in single and double precision.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::{SymbolicCholesky, SymbolicCholeskyRaw};
use faer::traits::RealField;
use faer::{MatMut, Par, Side};
use std::num::NonZeroUsize;

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

/// Factorises `L Lᵀ`; false where that fails.
pub(super) fn cholesky<T: RealField + Default>(
    symbolic: &SymbolicCholesky<usize>,
    entries: &mut Vec<T>,
    half: SparseColMatRef<'_, usize, T>,
    side: Side,
) -> bool {
    let scratch = symbolic.factorize_numeric_llt_scratch::<T>(shares(symbolic), Default::default());
    let Some(mut memory) = prepared(symbolic, entries, scratch) else { return false };
    let regularisation = LltRegularization::default();
    let (par, memory) = (shares(symbolic), MemStack::new(&mut memory));
    symbolic
        .factorize_numeric_llt(entries, half, side, regularisation, par, memory, Default::default())
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

/// Slots of the diagonal of a factor.
pub(super) fn pivots(symbolic: &SymbolicCholesky<usize>) -> impl Iterator<Item = usize> {
    let mut slots = Vec::with_capacity(symbolic.nrows());
    match symbolic.raw() {
        SymbolicCholeskyRaw::Supernodal(symbolic) => {
            let ends = symbolic.supernode_end();
            for (s, (&begin, end)) in symbolic.supernode_begin().iter().zip(ends).enumerate() {
                let [start, next] = [s, s + 1].map(|s| symbolic.col_ptr_for_val()[s]);
                let rows = (next - start).checked_div(end - begin).unwrap_or(0);
                slots.extend((0..end - begin).map(|i| start + i * (rows + 1)));
            }
        }
        // Tiny matrices have no supernodes, whatever is requested; the diagonal comes first in each column.
        SymbolicCholeskyRaw::Simplicial(symbolic) => {
            slots.extend(&symbolic.col_ptr()[..symbolic.ncols()]);
        }
    }
    slots.into_iter()
}

/// Division of a factor's blocks.
fn shares(symbolic: &SymbolicCholesky<usize>) -> Par {
    let alone = rayon::current_num_threads() == 1;
    if alone || symbolic.len_val() < LARGE { Par::Seq } else { Par::Rayon(SHARES) }
}
