//! The inverse of a triangular matrix, by halves.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::triangular_inverse::invert_lower_triangular;
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Order up to which the linear-algebra library inverts by itself.
const LEAF: usize = 64;

/// Writes L⁻¹ into the lower triangle of `out`; `lower` and `out` are stored by columns.
///
/// [A 0; B C]⁻¹ = [A⁻¹ 0; −C⁻¹ B A⁻¹ C⁻¹] puts nearly all of the work into products, which
/// measured two to three times as fast as the substitution of the linear-algebra library.
pub(crate) fn invert_lower(mut out: MatMut<'_, f64>, lower: MatRef<'_, f64>, par: Par) {
    let size = lower.nrows();
    if size <= LEAF {
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
pub(crate) fn side_by_side(
    par: Par,
    first: impl FnOnce(Par) + Send,
    second: impl FnOnce(Par) + Send,
) {
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
