//! Sparse matrices of small dense blocks.

use rayon::prelude::*;

/// Rows that one task works on.
const ROWS: usize = 256;

/// A small dense matrix.
pub(super) type Block<S, const R: usize, const C: usize> = [[S; C]; R];

/// A sparse matrix of `R × C` blocks, compressed by rows; columns ascend in each row.
#[derive(Clone, Debug)]
pub(super) struct BlockMatrix<S, const R: usize, const C: usize> {
    /// Number of block columns.
    pub width: usize,
    pub starts: Vec<usize>,
    pub columns: Vec<u32>,
    pub blocks: Vec<Block<S, R, C>>,
}

impl<S: Copy + Sync + Into<f64>, const R: usize, const C: usize> BlockMatrix<S, R, C> {
    /// Number of block rows.
    pub fn height(&self) -> usize {
        self.starts.len() - 1
    }

    /// Columns and blocks of a row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, &Block<S, R, C>)> + Clone {
        let range = self.starts[row]..self.starts[row + 1];
        self.columns[range.clone()].iter().map(|&c| c as usize).zip(&self.blocks[range])
    }

    /// `to = self · from`.
    pub fn multiply(&self, from: &[[f64; C]], to: &mut [[f64; R]]) {
        self.each_row(to, |product, sum| *product = sum, from);
    }

    /// `to −= self · from`.
    pub fn subtract_product(&self, from: &[[f64; C]], to: &mut [[f64; R]]) {
        self.each_row(to, |product, sum| (0..R).for_each(|i| product[i] -= sum[i]), from);
    }

    /// `to += self · from`.
    pub fn add_product(&self, from: &[[f64; C]], to: &mut [[f64; R]]) {
        self.each_row(to, |product, sum| (0..R).for_each(|i| product[i] += sum[i]), from);
    }

    fn each_row(
        &self,
        to: &mut [[f64; R]],
        put: impl Fn(&mut [f64; R], [f64; R]) + Sync,
        from: &[[f64; C]],
    ) {
        to.par_chunks_mut(ROWS).enumerate().for_each(|(chunk, products)| {
            for (inside, product) in products.iter_mut().enumerate() {
                let mut sum = [0.0; R];
                for (column, block) in self.row(chunk * ROWS + inside) {
                    let x = &from[column];
                    for (sum, row) in sum.iter_mut().zip(block) {
                        for (&a, x) in row.iter().zip(x) {
                            *sum += a.into() * x;
                        }
                    }
                }
                put(product, sum);
            }
        });
    }

    /// The transposed matrix.
    pub fn transposed(&self) -> BlockMatrix<S, C, R> {
        let mut starts = vec![0; self.width + 1];
        self.columns.iter().for_each(|&column| starts[column as usize + 1] += 1);
        (0..self.width).for_each(|i| starts[i + 1] += starts[i]);
        let mut next = starts.clone();
        let mut source = vec![(0, 0); self.columns.len()];
        for row in 0..self.height() {
            for at in self.starts[row]..self.starts[row + 1] {
                let place = &mut next[self.columns[at] as usize];
                source[*place] = (row as u32, at);
                *place += 1;
            }
        }
        let columns = source.iter().map(|&(row, _)| row).collect();
        let turn =
            |block: &Block<S, R, C>| std::array::from_fn(|i| std::array::from_fn(|j| block[j][i]));
        let blocks = source.iter().map(|&(_, at)| turn(&self.blocks[at])).collect();
        BlockMatrix { width: self.height(), starts, columns, blocks }
    }
}

impl<const R: usize, const C: usize> BlockMatrix<f64, R, C> {
    /// `self · right`. Sums are taken in the order of the columns, on any number of threads.
    pub fn product<const E: usize>(
        &self,
        right: &BlockMatrix<f64, C, E>,
    ) -> BlockMatrix<f64, R, E> {
        const ABSENT: u32 = u32::MAX;
        type Rows<const R: usize, const E: usize> = (Vec<u32>, Vec<u32>, Vec<Block<f64, R, E>>);
        let chunks: Vec<Rows<R, E>> = (0..self.height().div_ceil(ROWS))
            .into_par_iter()
            .map_init(
                || vec![ABSENT; right.width],
                |place, chunk| {
                    let (mut lengths, mut columns, mut blocks) = (vec![], vec![], vec![]);
                    let mut row_columns: Vec<u32> = Vec::new();
                    for row in chunk * ROWS..self.height().min((chunk + 1) * ROWS) {
                        row_columns.clear();
                        for (middle, _) in self.row(row) {
                            for &column in right.columns_of(middle) {
                                if place[column as usize] == ABSENT {
                                    place[column as usize] = 0;
                                    row_columns.push(column);
                                }
                            }
                        }
                        row_columns.sort_unstable();
                        let first = blocks.len();
                        for (at, &column) in row_columns.iter().enumerate() {
                            place[column as usize] = (first + at) as u32;
                        }
                        blocks.resize(first + row_columns.len(), [[0.0; E]; R]);
                        for (middle, a) in self.row(row) {
                            for (column, b) in right.row(middle) {
                                add_product(a, b, &mut blocks[place[column] as usize]);
                            }
                        }
                        row_columns.iter().for_each(|&column| place[column as usize] = ABSENT);
                        lengths.push(row_columns.len() as u32);
                        columns.extend_from_slice(&row_columns);
                    }
                    (lengths, columns, blocks)
                },
            )
            .collect();
        let mut starts = Vec::with_capacity(self.height() + 1);
        starts.push(0);
        let entries = chunks.iter().map(|(_, columns, _)| columns.len()).sum();
        let (mut columns, mut blocks) = (Vec::with_capacity(entries), Vec::with_capacity(entries));
        for (lengths, chunk_columns, chunk_blocks) in chunks {
            for length in lengths {
                starts.push(starts[starts.len() - 1] + length as usize);
            }
            columns.extend(chunk_columns);
            blocks.extend(chunk_blocks);
        }
        BlockMatrix { width: right.width, starts, columns, blocks }
    }

    fn columns_of(&self, row: usize) -> &[u32] {
        &self.columns[self.starts[row]..self.starts[row + 1]]
    }

    /// The matrix with its entries rounded.
    pub fn rounded(&self) -> BlockMatrix<f32, R, C> {
        let blocks = self.blocks.iter().map(|block| block.map(|row| row.map(|x| x as f32)));
        BlockMatrix {
            width: self.width,
            starts: self.starts.clone(),
            columns: self.columns.clone(),
            blocks: blocks.collect(),
        }
    }
}

/// `to += a · b`.
#[inline]
fn add_product<const R: usize, const C: usize, const E: usize>(
    a: &Block<f64, R, C>,
    b: &Block<f64, C, E>,
    to: &mut Block<f64, R, E>,
) {
    for (to, a) in to.iter_mut().zip(a) {
        for (&a, b) in a.iter().zip(b) {
            for (to, b) in to.iter_mut().zip(b) {
                *to += a * b;
            }
        }
    }
}

/// The inverse of a symmetric positive definite block; `None` where it is not definite.
pub(super) fn definite_inverse<const B: usize>(
    block: &Block<f64, B, B>,
) -> Option<Block<f64, B, B>> {
    // Rounding takes as much of a pivot.
    const SINGULAR: f64 = 1e-14;
    let mut lower = *block;
    for j in 0..B {
        for k in 0..j {
            let factor = lower[j][k];
            (j..B).for_each(|i| lower[i][j] -= lower[i][k] * factor);
        }
        let pivot = lower[j][j];
        // Written so that a NaN is refused as well.
        let definite = pivot > SINGULAR * block[j][j];
        if !definite {
            return None;
        }
        (j..B).for_each(|i| lower[i][j] /= pivot.sqrt());
    }
    let mut inverse = [[0.0; B]; B];
    for column in 0..B {
        let mut x = [0.0; B];
        x[column] = 1.0;
        for i in 0..B {
            (0..i).for_each(|k| x[i] -= lower[i][k] * x[k]);
            x[i] /= lower[i][i];
        }
        for i in (0..B).rev() {
            (i + 1..B).for_each(|k| x[i] -= lower[k][i] * x[k]);
            x[i] /= lower[i][i];
        }
        (0..B).for_each(|i| inverse[i][column] = x[i]);
    }
    Some(inverse)
}

/// A block times a vector.
#[inline]
pub(super) fn times<const R: usize, const C: usize>(
    block: &Block<f64, R, C>,
    x: &[f64; C],
) -> [f64; R] {
    block.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum())
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::aggregates::MODES;
    use super::super::samples::grid;
    use super::*;

    /// Spring of each node to the ground.
    pub(in crate::linear) const HELD: f64 = 1e-3;

    /// A grid of nodes with central and shear springs to those around, each held weakly; and its rigid motions.
    #[allow(clippy::type_complexity)]
    pub(in crate::linear) fn elastic_grid(
        size: [usize; 3],
    ) -> (BlockMatrix<f64, 3, 3>, Vec<Block<f64, 3, MODES>>) {
        let at = |v: usize| {
            [v % size[0], v / size[0] % size[1], v / size[0] / size[1]].map(|x| x as f64)
        };
        let spring = |a: usize, b: usize| -> Block<f64, 3, 3> {
            let (x, y) = (at(a), at(b));
            let d: [f64; 3] = std::array::from_fn(|i| x[i] - y[i]);
            let square: f64 = d.iter().map(|x| x * x).sum();
            std::array::from_fn(|i| std::array::from_fn(|j| d[i] * d[j] / square))
        };
        let (mut starts, mut columns, mut blocks) = (vec![0], Vec::new(), Vec::new());
        for (node, neighbours) in grid(size).iter().enumerate() {
            let mut row: Vec<(usize, Block<f64, 3, 3>)> = Vec::new();
            let mut own = [[HELD, 0.0, 0.0], [0.0, HELD, 0.0], [0.0, 0.0, HELD]];
            for &other in neighbours {
                let block = spring(node, other);
                own.as_flattened_mut()
                    .iter_mut()
                    .zip(block.as_flattened())
                    .for_each(|(o, b)| *o += b);
                row.push((other, block.map(|r| r.map(|x| -x))));
            }
            row.push((node, own));
            row.sort_unstable_by_key(|&(column, _)| column);
            columns.extend(row.iter().map(|&(column, _)| column as u32));
            blocks.extend(row.iter().map(|&(_, block)| block));
            starts.push(columns.len());
        }
        let width = starts.len() - 1;
        let modes = (0..width)
            .map(|v| {
                let [x, y, z] = at(v);
                [
                    [1.0, 0.0, 0.0, 0.0, z, -y],
                    [0.0, 1.0, 0.0, -z, 0.0, x],
                    [0.0, 0.0, 1.0, y, -x, 0.0],
                ]
            })
            .collect();
        (BlockMatrix { width, starts, columns, blocks }, modes)
    }

    fn dense<const R: usize, const C: usize>(matrix: &BlockMatrix<f64, R, C>) -> Vec<Vec<f64>> {
        let mut full = vec![vec![0.0; C * matrix.width]; R * matrix.height()];
        for row in 0..matrix.height() {
            for (column, block) in matrix.row(row) {
                for i in 0..R {
                    full[R * row + i][C * column..C * column + C].copy_from_slice(&block[i]);
                }
            }
        }
        full
    }

    /// A rectangular matrix without a pattern.
    fn sample() -> BlockMatrix<f64, 2, 3> {
        let block = |k: usize| {
            std::array::from_fn(|i| {
                std::array::from_fn(|j| ((7 * k + 3 * i + 5 * j) % 11) as f64 - 5.0)
            })
        };
        let columns = vec![0, 3, 1, 0, 2, 3];
        BlockMatrix {
            width: 4,
            starts: vec![0, 2, 2, 3, 6],
            columns,
            blocks: (0..6).map(block).collect(),
        }
    }

    #[test]
    fn products_and_transposes_are_those_of_the_dense_matrices() {
        let a = sample();
        let b = a.transposed();
        let (full_a, full_b) = (dense(&a), dense(&b));
        for (i, row) in full_a.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                assert_eq!(full_b[j][i], value);
            }
        }
        let product = dense(&a.product(&b));
        for (i, row) in full_a.iter().enumerate() {
            for (j, other) in full_a.iter().enumerate() {
                let expected: f64 = row.iter().zip(other).map(|(x, y)| x * y).sum();
                assert_eq!(product[i][j], expected, "small integers have no rounding");
            }
        }
        let x: Vec<[f64; 3]> = (0..4).map(|i| [i as f64, 1.0, -2.0]).collect();
        let mut y = vec![[1.0; 2]; 4];
        a.add_product(&x, &mut y);
        a.subtract_product(&x, &mut y);
        assert_eq!(y, vec![[1.0; 2]; 4]);
        a.multiply(&x, &mut y);
        let flat = x.as_flattened();
        for (value, row) in y.as_flattened().iter().zip(&full_a) {
            assert_eq!(*value, row.iter().zip(flat).map(|(a, x)| a * x).sum::<f64>());
        }
    }

    #[test]
    fn inverses_are_exact_or_refused() {
        let block = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 2.0]];
        let inverse = definite_inverse(&block).unwrap();
        for j in 0..3 {
            let column = times(&block, &std::array::from_fn(|i| inverse[i][j]));
            for (i, value) in column.into_iter().enumerate() {
                assert!((value - f64::from(u8::from(i == j))).abs() < 1e-15);
            }
        }
        for bad in
            [[[1.0, 2.0], [2.0, 1.0]], [[1.0, 1.0], [1.0, 1.0]], [[f64::NAN, 0.0], [0.0, 1.0]]]
        {
            assert!(definite_inverse(&bad).is_none());
        }
    }
}
