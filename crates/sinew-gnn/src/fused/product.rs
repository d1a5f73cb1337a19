//! Products of row-major matrices a few hundred wide, on one thread.
//!
//! A weight is packed once into [`Panels`] as wide as the registers hold; then a block of sums
//! stays in registers while its rows run along a panel. At these sizes this is three times as
//! fast as a general product, which packs both factors for every call.

mod kernel;

use crate::fused::pool::{Buffer, LINE};
use crate::fused::simd::{Instructions, instructions};

/// Narrowest panel; widths are multiples of it.
const LANES: usize = 8;
/// Widest panel, of the registers of AVX-512 that leave room for the sums of six rows.
const WIDEST: usize = 8 * LANES;

/// A matrix packed into panels of some columns, each row by row, filled up with zeros.
pub(crate) struct Panels {
    values: Buffer,
    pub depth: usize,
    pub columns: usize,
}

impl Panels {
    /// Panels of a matrix with rows of `columns` numbers.
    pub(crate) fn new(matrix: &[f32], columns: usize) -> Self {
        let depth = matrix.len() / columns.max(1);
        Self::pack(depth, columns, |row, column, panel| {
            panel.copy_from_slice(&matrix[row * columns + column..][..panel.len()]);
        })
    }

    /// Panels of the transpose of a matrix with rows of `columns` numbers.
    pub(crate) fn transposed(matrix: &[f32], columns: usize) -> Self {
        let rows = matrix.len() / columns.max(1);
        Self::pack(columns, rows, |row, column, panel| {
            let from = matrix[column * columns + row..].iter().step_by(columns);
            for (to, from) in panel.iter_mut().zip(from) {
                *to = *from;
            }
        })
    }

    /// `copy(row, column, panel)` writes the numbers of `row` from `column` on.
    fn pack(depth: usize, columns: usize, copy: impl Fn(usize, usize, &mut [f32])) -> Self {
        let mut values = Buffer::take(depth * columns.next_multiple_of(LANES));
        for Panel { start, width } in panels(columns, WIDEST) {
            let panel = &mut values[start * depth..(start + width) * depth];
            let valid = width.min(columns - start);
            for (row, to) in panel.chunks_exact_mut(width).enumerate() {
                copy(row, start, &mut to[..valid]);
                to[valid..].fill(0.0);
            }
        }
        Self { values, depth, columns }
    }
}

/// Columns of a matrix that are multiplied together.
#[derive(Clone, Copy)]
struct Panel {
    start: usize,
    width: usize,
}

/// Panels of so many columns at most. The last ones cover the remainder, half a register of AVX-512 where no more is left.
fn panels(columns: usize, widest: usize) -> impl Iterator<Item = Panel> {
    let widest = match instructions() {
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx512 => widest,
        _ => 2 * LANES,
    };
    let mut start = 0;
    std::iter::from_fn(move || {
        let left = columns.saturating_sub(start).next_multiple_of(LANES);
        let width = if left > LANES { left - left % (2 * LANES) } else { left }.min(widest);
        start += width;
        (width > 0).then_some(Panel { start: start - width, width })
    })
}

/// Summand of a product.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Start {
    /// Zero: the product is written over the output.
    Zero,
    /// The output.
    Kept,
}

/// `output = rows · weight`, or added to the output.
pub(crate) fn multiply(rows: &[f32], weight: &Panels, start: Start, output: &mut [f32]) {
    let Panels { values, depth, columns } = weight;
    if *columns == 0 || output.is_empty() {
        return;
    }
    let count = output.len() / columns;
    assert_eq!(rows.len(), count * depth, "factors of a product");
    for panel in panels(*columns, WIDEST) {
        let task = Task {
            count,
            depth: *depth,
            factor: rows,
            row_stride: *depth,
            step: 1,
            panel: &values[panel.start * depth..(panel.start + panel.width) * depth],
            stride: panel.width,
            columns: *columns,
            start: panel.start,
            kept: start == Start::Kept,
        };
        task.run(panel.width, output);
    }
}

/// `gram = xᵀ x`, where `x` has rows of `size` numbers; only one triangle is computed. Of a
/// symmetric `x` it is the square.
pub(crate) fn gram(x: &[f32], size: usize, gram: &mut [f32]) {
    // Narrow ones have few numbers beyond the diagonal.
    for panel in panels(size, WIDEST / 2) {
        // Rows from the diagonal on.
        let rows = &mut gram[panel.start * size..];
        multiply_transposed(&x[panel.start..], size, (x, size), panel, Start::Zero, rows);
    }
    mirror(gram, size);
}

/// Copies the lower triangle to the upper one, block by block for the cache's sake.
fn mirror(matrix: &mut [f32], size: usize) {
    for from in (0..size).step_by(LINE) {
        for i in from..size {
            for j in from..(from + LINE).min(i) {
                matrix[j * size + i] = matrix[i * size + j];
            }
        }
    }
}

/// `sum += xᵀ d`, where `x` has rows of `width` numbers and `sum` has `width` rows.
pub(crate) fn add_transposed_product(x: &[f32], width: usize, d: &[f32], sum: &mut [f32]) {
    if width == 0 || sum.is_empty() || x.is_empty() {
        return;
    }
    let (columns, rows) = (sum.len() / width, x.len() / width);
    assert_eq!(d.len(), rows * columns, "factors of a product");
    for panel in panels(columns, WIDEST) {
        multiply_transposed(x, width, (d, columns), panel, Start::Kept, sum);
    }
}

/// A panel of `output = xᵀ d`, or added to the output, where x has numbers at steps of `step`, and d rows of `columns` numbers.
fn multiply_transposed(
    x: &[f32],
    step: usize,
    (d, columns): (&[f32], usize),
    panel: Panel,
    start: Start,
    output: &mut [f32],
) {
    // A panel that juts out is copied and filled up.
    let juts_out = panel.start + panel.width > columns;
    let packed = juts_out.then(|| pack_columns(d, columns, panel));
    let (values, stride) = match &packed {
        Some(packed) => (&packed[..], panel.width),
        None => (&d[panel.start..], columns),
    };
    let task = Task {
        count: output.len() / columns,
        depth: d.len() / columns,
        factor: x,
        row_stride: 1,
        step,
        panel: values,
        stride,
        columns,
        start: panel.start,
        kept: start == Start::Kept,
    };
    task.run(panel.width, output);
}

fn pack_columns(d: &[f32], columns: usize, panel: Panel) -> Buffer {
    let mut packed = Buffer::zeros(d.len() / columns * panel.width);
    for (to, from) in packed.chunks_exact_mut(panel.width).zip(d.chunks_exact(columns)) {
        let from = &from[panel.start..];
        to[..from.len()].copy_from_slice(from);
    }
    packed
}

/// Product of a factor, whose numbers are spread over a register one by one, with one panel.
struct Task<'a> {
    /// Rows of the output.
    count: usize,
    /// Length of the sums.
    depth: usize,
    factor: &'a [f32],
    /// Stride from a number of the factor to that of the next row of the output.
    row_stride: usize,
    /// Stride from a number of the factor to the next one of the sum.
    step: usize,
    panel: &'a [f32],
    /// Distance of the panel's rows.
    stride: usize,
    /// Columns of the output.
    columns: usize,
    /// First column of the panel.
    start: usize,
    kept: bool,
}

impl Task<'_> {
    /// Product with a panel of `width` columns.
    fn run(&self, width: usize, output: &mut [f32]) {
        // What the blocks below rely on.
        let last = |count: usize, stride: usize| (count - 1) * stride;
        assert!(self.count > 0 && output.len() == self.count * self.columns);
        assert!(self.start < self.columns && width.is_multiple_of(LANES));
        assert!((LANES..=WIDEST).contains(&width));
        if self.depth > 0 {
            let end = last(self.count, self.row_stride) + last(self.depth, self.step);
            assert!(end < self.factor.len());
            assert!(last(self.depth, self.stride) + width <= self.panel.len());
        }
        // SAFETY: `instructions` returns only what the processor reports; the kernels stay inside the slices by the
        // assertions above.
        unsafe {
            match instructions() {
                #[cfg(target_arch = "x86_64")]
                Instructions::Avx512 if width > LANES => kernel::avx512::run(self, width, output),
                #[cfg(target_arch = "x86_64")]
                Instructions::Avx512 | Instructions::Avx2 => kernel::avx2::run(self, width, output),
                Instructions::Baseline => kernel::portable::run(self, width, output),
            }
        }
    }
}
