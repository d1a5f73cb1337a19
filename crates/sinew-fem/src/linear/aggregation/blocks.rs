//! Sparse matrices of small dense blocks.

use crate::linear::compressed;
use nalgebra::{RealField, SMatrix};
use sinew_num::{fill, in_parallel};
use std::ops::Range;

/// Rows of one task: a fixed division, so that results do not depend on the number of threads.
pub(super) const ROWS: usize = 256;

/// A small dense matrix.
pub(super) type Block<T, const R: usize, const C: usize> = [[T; C]; R];

/// A sparse matrix of `R × C` blocks, compressed by rows; columns ascend in each row.
pub(super) struct BlockMatrix<T, const R: usize, const C: usize> {
    /// Number of block columns.
    pub width: usize,
    pub starts: Vec<usize>,
    pub columns: Vec<u32>,
    pub blocks: Vec<Block<T, R, C>>,
}

impl<T: RealField + Copy, const R: usize, const C: usize> BlockMatrix<T, R, C> {
    /// Number of block rows.
    pub(super) fn height(&self) -> usize {
        self.starts.len() - 1
    }

    /// Columns and blocks of a row.
    pub(super) fn row(&self, row: usize) -> impl Iterator<Item = (usize, &Block<T, R, C>)> {
        let range = self.starts[row]..self.starts[row + 1];
        self.columns[range.clone()].iter().map(|&c| c as usize).zip(&self.blocks[range])
    }

    /// `to = self · from`.
    pub(super) fn multiply(&self, from: &[[T; C]], to: &mut [[T; R]]) {
        self.for_rows(from, to, |to, product| *to = product);
    }

    /// `to −= self · from`.
    pub(super) fn subtract_product(&self, from: &[[T; C]], to: &mut [[T; R]]) {
        self.for_rows(from, to, |to, product| (0..R).for_each(|i| to[i] -= product[i]));
    }

    /// Calls `put` with each row of a vector and of the product with another one.
    fn for_rows(
        &self,
        from: &[[T; C]],
        to: &mut [[T; R]],
        put: impl Fn(&mut [T; R], [T; R]) + Sync,
    ) {
        in_parallel(to.chunks_mut(ROWS).enumerate(), |(chunk, to)| {
            for (inside, to) in to.iter_mut().enumerate() {
                let mut sum = [T::zero(); R];
                for (column, block) in self.row(chunk * ROWS + inside) {
                    let product = times(block, &from[column]);
                    (0..R).for_each(|i| sum[i] += product[i]);
                }
                put(to, sum);
            }
        });
    }

    pub(super) fn transposed(&self) -> BlockMatrix<T, C, R> {
        let mut starts = vec![0; self.width + 1];
        self.columns.iter().for_each(|&column| starts[column as usize + 1] += 1);
        (0..self.width).for_each(|i| starts[i + 1] += starts[i]);
        let mut next = starts.clone();
        let (mut columns, mut sources) = (vec![0; self.columns.len()], vec![0; self.columns.len()]);
        for row in 0..self.height() {
            for source in self.starts[row]..self.starts[row + 1] {
                let slot = &mut next[self.columns[source] as usize];
                (columns[*slot], sources[*slot]) = (row as u32, source as u32);
                *slot += 1;
            }
        }
        let mut blocks = vec![[[T::zero(); R]; C]; self.columns.len()];
        fill(&mut blocks, ROWS, |slot| {
            let block = &self.blocks[sources[slot] as usize];
            std::array::from_fn(|i| std::array::from_fn(|j| block[j][i]))
        });
        BlockMatrix { width: self.height(), starts, columns, blocks }
    }

    /// `self · right`, with sums in the order of the columns.
    pub(super) fn product<const E: usize>(
        &self,
        right: &BlockMatrix<T, C, E>,
    ) -> BlockMatrix<T, R, E> {
        let columns_of = |rows: Range<usize>| {
            let mut seen = vec![usize::MAX; right.width];
            let (mut columns, mut ends) = (Vec::new(), Vec::new());
            for row in rows {
                let first = columns.len();
                for (middle, _) in self.row(row) {
                    for &column in &right.columns[right.starts[middle]..right.starts[middle + 1]] {
                        if std::mem::replace(&mut seen[column as usize], row) != row {
                            columns.push(column);
                        }
                    }
                }
                columns[first..].sort_unstable();
                ends.push(columns.len());
            }
            (columns, ends)
        };
        let (starts, columns) = compressed(in_parallel(self.chunks(), columns_of));
        let blocks = vec![[[T::zero(); E]; R]; columns.len()];
        let mut product = BlockMatrix { width: right.width, starts, columns, blocks };
        let tables = || vec![0; right.width];
        product.change_rows(tables, |slots, row, columns, blocks| {
            // A page of new zeros that is read before it is written is mapped twice, and the second time interrupts all threads.
            blocks.fill([[T::zero(); E]; R]);
            for (slot, &column) in columns.iter().enumerate() {
                slots[column as usize] = slot;
            }
            for (middle, left) in self.row(row) {
                for (column, other) in right.row(middle) {
                    add_product(left, other, &mut blocks[slots[column]]);
                }
            }
        });
        product
    }

    /// Rows in a few chunks for each thread, for tasks with memory of their own. Each row is computed alone, so that the division changes no number.
    fn chunks(&self) -> impl Iterator<Item = Range<usize>> + use<T, R, C> {
        let height = self.height();
        let size = ROWS.max(height.div_ceil(8 * rayon::current_num_threads()));
        (0..height).step_by(size).map(move |first| first..height.min(first + size))
    }

    /// Calls `change` with each row, its columns and its blocks, and with memory that `make` makes for each task.
    pub(super) fn change_rows<M>(
        &mut self,
        make: impl Fn() -> M + Sync,
        change: impl Fn(&mut M, usize, &[u32], &mut [Block<T, R, C>]) + Sync,
    ) {
        let (chunks, mut tasks, mut rest) = (self.chunks(), Vec::new(), &mut self.blocks[..]);
        for rows in chunks {
            let size = self.starts[rows.end] - self.starts[rows.start];
            let (blocks, others) = rest.split_at_mut(size);
            tasks.push((rows, blocks));
            rest = others;
        }
        let (starts, columns) = (&self.starts, &self.columns);
        in_parallel(tasks, |(rows, mut blocks): (Range<usize>, _)| {
            let mut memory = make();
            for row in rows {
                let range = starts[row]..starts[row + 1];
                let (own, others) = blocks.split_at_mut(range.len());
                change(&mut memory, row, &columns[range], own);
                blocks = others;
            }
        });
    }
}

impl<const R: usize, const C: usize> BlockMatrix<f64, R, C> {
    /// The matrix in single precision.
    pub(super) fn rounded(&self) -> BlockMatrix<f32, R, C> {
        let mut blocks = vec![[[0.0; C]; R]; self.blocks.len()];
        fill(&mut blocks, ROWS, |block| single(&self.blocks[block]));
        let (starts, columns) = (self.starts.clone(), self.columns.clone());
        BlockMatrix { width: self.width, starts, columns, blocks }
    }
}

/// A block in single precision.
pub(super) fn single<const R: usize, const C: usize>(block: &Block<f64, R, C>) -> Block<f32, R, C> {
    block.map(|row| row.map(|x| x as f32))
}

/// `to += left · right`.
pub(super) fn add_product<T: RealField + Copy, const R: usize, const C: usize, const E: usize>(
    left: &Block<T, R, C>,
    right: &Block<T, C, E>,
    to: &mut Block<T, R, E>,
) {
    for (to, left) in to.iter_mut().zip(left) {
        for (&left, right) in left.iter().zip(right) {
            (0..E).for_each(|j| to[j] += left * right[j]);
        }
    }
}

/// A block times a vector.
pub(super) fn times<T: RealField + Copy, const R: usize, const C: usize>(
    block: &Block<T, R, C>,
    x: &[T; C],
) -> [T; R] {
    block.map(|row| {
        let mut sum = T::zero();
        (0..C).for_each(|j| sum += row[j] * x[j]);
        sum
    })
}

/// Inverse of a symmetric positive definite block; `None` where it is not.
pub(super) fn definite_inverse<const B: usize>(
    block: &Block<f64, B, B>,
) -> Option<Block<f64, B, B>> {
    /// Least pivot \[relative to the diagonal\]: smaller ones are rounding errors.
    const SINGULAR: f64 = 1e-14;
    let factor = SMatrix::<f64, B, B>::from_fn(|i, j| block[i][j]).cholesky()?;
    let lower = factor.l_dirty();
    let definite = (0..B).all(|i| lower[(i, i)] * lower[(i, i)] > SINGULAR * block[i][i]);
    let inverse = factor.inverse();
    definite.then(|| std::array::from_fn(|i| std::array::from_fn(|j| inverse[(i, j)])))
}
