//! Cholesky factors, and inverses of triangular matrices, by halves.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// A lower triangular matrix, stored column by column; what is above the diagonal means nothing.
#[derive(Clone, Debug)]
pub(crate) struct Factor {
    entries: Vec<f64>,
    size: usize,
}

/// Order up to which the linear-algebra library factorises by itself.
const FACTORED_LEAF: usize = 320;

/// Overwrites the lower triangle with that of L; none where the matrix is not positive definite.
///
/// By halves, [A; B C]: L_A, then B L_A⁻ᵀ with rows side by side, then C less its square, so that all but
/// the leaves is shared between threads. The library's own shares next to
/// nothing at a few hundred rows: with 600 it took two threads as long as one.
fn factorise(mut matrix: MatMut<'_, f64>, par: Par) -> Option<()> {
    let size = matrix.nrows();
    if size <= FACTORED_LEAF {
        let scratch = cholesky_in_place_scratch::<f64>(size, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut memory);
        let regularization = LltRegularization::default();
        cholesky_in_place(matrix, regularization, Par::Seq, stack, Default::default()).ok()?;
        return Some(());
    }
    let half = (size / 2).next_multiple_of(8);
    let (mut a, _, mut b, mut c) = matrix.rb_mut().split_at_mut(half, half);
    factorise(a.rb_mut(), par)?;
    let (upper, lower) = b.rb_mut().split_at_row_mut(((size - half) / 2).next_multiple_of(8));
    let solve = |rows: MatMut<'_, f64>, par: Par| {
        solve_lower_triangular_in_place(a.rb(), rows.transpose_mut(), par);
    };
    side_by_side(par, |par| solve(upper, par), |par| solve(lower, par));
    let (full, low) = (BlockStructure::Rectangular, BlockStructure::TriangularLower);
    let middle = ((size - half) / 2).next_multiple_of(8);
    let (upper, lower) = b.rb().split_at_row(middle);
    let (c1, _, c2, c3) = c.rb_mut().split_at_mut(middle, middle);
    side_by_side(
        par,
        |par| {
            matmul(c1, low, Accum::Add, upper, full, upper.transpose(), full, -1.0, par);
            matmul(c3, low, Accum::Add, lower, full, lower.transpose(), full, -1.0, par);
        },
        |par| matmul(c2, full, Accum::Add, lower, full, upper.transpose(), full, -1.0, par),
    );
    factorise(c, par)
}

impl Factor {
    /// Cholesky factor of a symmetric matrix by its lower triangle; none where it is not positive
    /// definite or not finite.
    pub(crate) fn new(mut entries: Vec<f64>, size: usize, par: Par) -> Option<Self> {
        let mut columns = entries.chunks(size.max(1)).enumerate();
        if !columns.all(|(at, column)| column[at..].iter().all(|entry| entry.is_finite())) {
            return None;
        }
        factorise(MatMut::from_column_major_slice_mut(&mut entries, size, size), par)?;
        Some(Self { entries, size })
    }

    pub(crate) fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.entries, self.size, self.size)
    }

    /// Rows at and below the diagonal of a column.
    pub(crate) fn column(&self, column: usize) -> &[f64] {
        &self.entries[column * self.size + column..(column + 1) * self.size]
    }

    /// x ← L⁻¹ x.
    pub(crate) fn forward(&self, x: &mut [f64]) {
        for column in 0..x.len() {
            let (pivot, below) = self.column(column).split_first().expect("a diagonal entry");
            let (value, rest) = x[column..].split_first_mut().expect("a column of x");
            *value /= pivot;
            rest.iter_mut().zip(below).for_each(|(x, l)| *x -= *value * l);
        }
    }

    /// x ← L⁻ᵀ x, for the leading rows of L as many as x has.
    pub(crate) fn backward(&self, x: &mut [f64]) {
        for column in (0..x.len()).rev() {
            let (pivot, below) = self.column(column).split_first().expect("a diagonal entry");
            let (value, rest) = x[column..].split_first_mut().expect("a column of x");
            *value = (*value - rest.iter().zip(below).map(|(x, l)| x * l).sum::<f64>()) / pivot;
        }
    }
}

/// Order up to which the linear-algebra library inverts by itself.
const INVERTED_LEAF: usize = 64;

/// Writes L⁻¹ into the lower triangle of `out`; `lower` and `out` are stored by columns.
///
/// [A 0; B C]⁻¹ = [A⁻¹ 0; −C⁻¹ B A⁻¹ C⁻¹] puts nearly all of the work into products, which
/// measured two to three times as fast as the substitution of the linear-algebra library.
pub(crate) fn invert_lower(mut out: MatMut<'_, f64>, lower: MatRef<'_, f64>, par: Par) {
    let size = lower.nrows();
    if size <= INVERTED_LEAF {
        return invert_lower_triangular(out, lower, Par::Seq);
    }
    let half = (size / 2).next_multiple_of(8);
    let (mut first, _, mut below, mut second) = out.rb_mut().split_at_mut(half, half);
    let (a, _, b, c) = lower.split_at(half, half);
    side_by_side(
        par,
        |par| invert_lower(first.rb_mut(), a, par),
        |par| invert_lower(second.rb_mut(), c, par),
    );
    let mut product = Mat::<f64>::zeros(size - half, half);
    let (full, low) = (BlockStructure::Rectangular, BlockStructure::TriangularLower);
    matmul(product.as_mut(), full, Accum::Replace, second.rb(), low, b, full, -1.0, par);
    matmul(below.rb_mut(), full, Accum::Replace, product.as_ref(), full, first.rb(), low, 1.0, par);
}

/// Calls `each` for the columns of a matrix of an order, with memory of its thread. A sequential call stays on its own thread: a pool
/// of threads costs more than it saves on a small matrix.
pub(crate) fn for_columns<M: Default>(
    par: Par,
    (matrix, order): (&mut [f64], usize),
    each: impl Fn((usize, &mut [f64]), &mut M) + Sync,
) {
    if par == Par::Seq {
        let mut memory = M::default();
        return matrix.chunks_mut(order).enumerate().for_each(|column| each(column, &mut memory));
    }
    let columns = matrix.par_chunks_mut(order).enumerate();
    columns.for_each_init(M::default, |memory, column| each(column, memory));
}

/// Two independent halves of some work, each with its share of the threads.
fn side_by_side(par: Par, first: impl FnOnce(Par) + Send, second: impl FnOnce(Par) + Send) {
    match par {
        Par::Seq => {
            first(Par::Seq);
            second(Par::Seq);
        }
        Par::Rayon(threads) => {
            let half = if threads.get() > 3 { Par::rayon(threads.get() / 2) } else { Par::Seq };
            rayon::join(|| first(half), || second(half));
        }
    }
}
