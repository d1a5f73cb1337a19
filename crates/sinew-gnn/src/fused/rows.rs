//! Gathers, scatters and sums of rows.

use crate::fused::activation::{Activation, celu, for_activation, tanh};
use crate::fused::index::Gather;
use crate::fused::simd::{dot, vectorised};
use rayon::prelude::*;

/// Target rows that one task of the scatter adds up.
const ROWS_PER_TASK: usize = 64;

/// Adds to each target's sum `sign` times those `rows` that it is referred to by.
pub(crate) fn add_up(
    rows: &[f32],
    inverse: &[Vec<usize>],
    sign: f32,
    width: usize,
    sums: &mut [f32],
) {
    sums.par_chunks_mut(ROWS_PER_TASK * width).enumerate().for_each(|(task, sums)| {
        add_up_targets(rows, inverse, sign, task * ROWS_PER_TASK, width, sums);
    });
}

/// The row of a source that `row` reads.
#[inline(always)]
fn row_of<'a>((gather, source): &(&Gather, &'a [f32]), row: usize, width: usize) -> &'a [f32] {
    &source[gather.source(row) * width..][..width]
}

vectorised! {
    fn add_up_targets<FUSED>(
        rows: &[f32],
        inverse: &[Vec<usize>],
        sign: f32,
        start: usize,
        width: usize,
        sums: &mut [f32],
    ) {
        for (offset, sum) in sums.chunks_exact_mut(width).enumerate() {
            for &row in &inverse[start + offset] {
                for (sum, value) in sum.iter_mut().zip(&rows[row * width..][..width]) {
                    *sum += sign * value;
                }
            }
        }
    }

    /// `x = f(x + bias + Σ_k source_k[index_k[row]])` for consecutive rows from `start` on.
    pub(crate) fn gather_and_activate<FUSED>(
        activation: Activation,
        bias: &[f32],
        sources: &[(&Gather, &[f32])],
        start: usize,
        x: &mut [f32],
    ) {
        let width = bias.len();
        for (offset, x) in x.chunks_exact_mut(width).enumerate() {
            let row = start + offset;
            for_activation!(activation, celu::<FUSED>, tanh::<FUSED>, |f| if let [first, second] = sources {
                let (first, second) = (row_of(first, row, width), row_of(second, row, width));
                for ((x, b), (first, second)) in x.iter_mut().zip(bias).zip(first.iter().zip(second)) {
                    *x = f(*x + b + first + second);
                }
            } else {
                sources.iter().for_each(|source| add_into(x, row_of(source, row, width)));
                x.iter_mut().zip(bias).for_each(|(x, b)| *x = f(*x + b));
            });
        }
    }

    /// Adds `rows`, from row `start` on, to the rows of the source they were gathered from.
    pub(crate) fn add_gathered_rows<FUSED>(gather: &Gather, start: usize, width: usize, rows: &[f32], sums: &mut [f32]) {
        for (offset, row) in rows.chunks_exact(width).enumerate() {
            let sum = &mut sums[gather.source(start + offset) * width..][..width];
            for (sum, value) in sum.iter_mut().zip(row) {
                *sum += value;
            }
        }
    }

    /// Products of the rows of `hidden` with the one column of a last layer.
    pub(crate) fn single_output<FUSED>(weight: &[f32], hidden: &[f32], output: &mut [f32]) {
        for (row, output) in hidden.chunks_exact(weight.len()).zip(output) {
            *output = dot::<FUSED>(row, weight);
        }
    }

    /// Adds `bias` to every row.
    pub(crate) fn add_to_rows<FUSED>(bias: &[f32], rows: &mut [f32]) {
        for row in rows.chunks_exact_mut(bias.len()) {
            for (x, b) in row.iter_mut().zip(bias) {
                *x += b;
            }
        }
    }

    /// Adds every row to `sum`.
    pub(crate) fn add_rows_into<FUSED>(sum: &mut [f32], rows: &[f32]) {
        for row in rows.chunks_exact(sum.len()) {
            for (sum, x) in sum.iter_mut().zip(row) {
                *sum += x;
            }
        }
    }

    /// Adds `values` to `sum`.
    pub(crate) fn add_into<FUSED>(sum: &mut [f32], values: &[f32]) {
        for (sum, value) in sum.iter_mut().zip(values) {
            *sum += value;
        }
    }
}
