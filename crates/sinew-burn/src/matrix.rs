//! Products of row-major matrices on one thread.

use gemm::{Parallelism, gemm};

/// A row-major matrix, or the transpose of one.
#[derive(Clone, Copy)]
pub(crate) struct Matrix<'a> {
    values: &'a [f32],
    rows: usize,
    columns: usize,
    row_stride: usize,
    column_stride: usize,
}

impl<'a> Matrix<'a> {
    /// Rows of `columns` numbers.
    pub fn new(values: &'a [f32], columns: usize) -> Self {
        let rows = values.len() / columns;
        Self { values, rows, columns, row_stride: columns, column_stride: 1 }
    }

    pub fn transposed(self) -> Self {
        Self {
            values: self.values,
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
        }
    }
}

/// `output = scale · a b`, added to `kept · output` unless `kept` is zero.
pub(crate) fn multiply(output: &mut [f32], kept: f32, scale: f32, a: Matrix<'_>, b: Matrix<'_>) {
    assert_eq!(a.columns, b.rows, "inner dimensions of a product");
    assert_eq!(output.len(), a.rows * b.columns, "size of a product");
    for matrix in [a, b] {
        assert_eq!(matrix.values.len(), matrix.rows * matrix.columns, "size of a factor");
    }
    // SAFETY: each pointer with its strides stays inside its slice, by the sizes checked above;
    // the output is borrowed exclusively and therefore overlaps neither factor.
    unsafe {
        gemm(
            a.rows,
            b.columns,
            a.columns,
            output.as_mut_ptr(),
            1,
            b.columns as isize,
            kept != 0.0,
            a.values.as_ptr(),
            a.column_stride as isize,
            a.row_stride as isize,
            b.values.as_ptr(),
            b.column_stride as isize,
            b.row_stride as isize,
            kept,
            scale,
            false,
            false,
            false,
            Parallelism::None,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::{Matrix, multiply};

    #[test]
    fn products_of_matrices_and_their_transposes() {
        let a = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]; // 2×3
        let b = [1.0, 0.0, 2.0, 1.0, 0.0, 3.0]; // 3×2
        let mut c = [1.0; 4];
        multiply(&mut c, 0.0, 1.0, Matrix::new(&a, 3), Matrix::new(&b, 2));
        assert_eq!(c, [5.0, 11.0, 14.0, 23.0]);
        multiply(
            &mut c,
            1.0,
            2.0,
            Matrix::new(&b, 2).transposed(),
            Matrix::new(&a, 3).transposed(),
        );
        assert_eq!(c, [15.0, 39.0, 36.0, 69.0]);
        let mut d = [0.0; 9];
        multiply(
            &mut d,
            0.0,
            1.0,
            Matrix::new(&a, 3).transposed(),
            Matrix::new(&b, 2).transposed(),
        );
        assert_eq!(d, [1.0, 6.0, 12.0, 2.0, 9.0, 15.0, 3.0, 12.0, 18.0]);
    }
}
