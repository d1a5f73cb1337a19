//! The inverse of a triangular matrix, by halves.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use sinew_num::vectorised;

/// Order up to which rows are eliminated one by one: as many as the nearest cache holds.
const LEAF: usize = 64;
/// Numbers of a vector register.
const LANES: usize = 8;
/// Registers of a row, one more than needed: rows a power of two apart get in each other's way in the cache,
/// which costs six times the time.
const STRIDE: usize = LEAF / LANES + 1;

/// Writes L⁻¹ into the lower triangle of `out`; `lower` and `out` are stored by columns.
///
/// [A 0; B C]⁻¹ = [A⁻¹ 0; −C⁻¹ B A⁻¹ C⁻¹] puts nearly all of the work into products, which
/// measured two to three times as fast as the substitution of the linear-algebra library.
pub(crate) fn invert_lower(mut out: MatMut<'_, f64>, lower: MatRef<'_, f64>, par: Par) {
    let size = lower.nrows();
    if size <= LEAF {
        return invert_leaf(out, lower);
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

/// Two independent halves of some work, each with what is left to it of the threads.
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

/// Row by row, X ← L⁻¹ from the identity: rows below a pivot are independent of each other, so that the
/// processor need not wait for one to begin the next.
fn invert_leaf(mut out: MatMut<'_, f64>, lower: MatRef<'_, f64>) {
    let size = lower.nrows();
    let mut rows = [[[0.0; LANES]; STRIDE]; LEAF];
    for k in 0..size {
        let column = lower.col(k).try_as_col_major().expect("stored by columns").as_slice();
        let (above, below) = rows[..size].split_at_mut(k + 1);
        let pivot = &mut above[k];
        pivot[k / LANES][k % LANES] = 1.0;
        eliminate(&mut pivot[..k / LANES + 1], below, &column[k..]);
    }
    for j in 0..size {
        let column = out.rb_mut().col_mut(j).try_as_col_major_mut().expect("stored by columns");
        let entries = column.as_slice_mut()[j..].iter_mut().zip(&rows[j..size]);
        entries.for_each(|(entry, row)| *entry = row[j / LANES][j % LANES]);
    }
}

/// A row in vector registers.
type Row = [[f64; LANES]; STRIDE];

vectorised! {
    fn eliminate(pivot: &mut [[f64; LANES]], below: &mut [Row], column: &[f64]) {
        let scale = column[0].recip();
        for lanes in pivot.iter_mut() {
            lanes.iter_mut().for_each(|x| *x *= scale);
        }
        for (row, factor) in below.iter_mut().zip(&column[1..]) {
            for (row, pivot) in row.iter_mut().zip(pivot.iter()) {
                for (x, p) in row.iter_mut().zip(pivot) {
                    *x -= factor * p;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_the_matrix_is_the_identity() {
        for size in [1, 7, 48, 49, 130, 301] {
            let lower = Mat::from_fn(size, size, |i, j| match i.cmp(&j) {
                std::cmp::Ordering::Less => 0.0,
                std::cmp::Ordering::Equal => 2.0 + (i as f64).sin(),
                std::cmp::Ordering::Greater => ((3 * i + 7 * j) as f64).sin() / size as f64,
            });
            let mut inverse = Mat::zeros(size, size);
            invert_lower(inverse.as_mut(), lower.as_ref(), Par::Seq);
            let mut side_by_side = Mat::zeros(size, size);
            invert_lower(side_by_side.as_mut(), lower.as_ref(), Par::rayon(2));
            assert_eq!(inverse, side_by_side, "the bits do not depend on the threads");
            let difference = &lower * &inverse - Mat::<f64>::identity(size, size);
            assert!(difference.norm_max() < 1e-14 * size as f64, "{size}");
        }
    }
}
