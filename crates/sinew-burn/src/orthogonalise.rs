//! The Newton–Schulz iteration of the Muon optimiser.

use crate::pool::Buffer;
use crate::product::{Panels, Start, gram, multiply};
use crate::simd::vectorised;
use burn::tensor::{DType, Tensor, TensorData};
use rayon::prelude::*;

/// Iterations; five bring singular values from 10⁻² to near one.
const ITERATIONS: usize = 5;
/// Coefficients of `σ ↦ a σ + b σ³ + c σ⁵`, which has the steepest slope at zero among those
/// that map [0, 1] near one (Jordan et al., Muon, 2024).
const COEFFICIENTS: [f32; 3] = [3.4445, -4.775, 2.0315];
/// Norm below which a matrix counts as zero and is left small.
const SMALLEST_NORM: f64 = 1e-7;

/// Replaces every matrix `U S Vᵀ` by nearly `U Vᵀ`, with singular values between about 0.7 and 1.2:
/// the update direction of Muon. Matrices are spread over threads; zero stays zero.
///
/// ```
/// use burn::tensor::{Device, Tensor};
///
/// let update = Tensor::<2>::from_floats([[3.0, 0.0], [0.0, -1e-1]], &Device::flex());
/// let direction = sinew_burn::orthogonalise(vec![update]).remove(0).into_data().try_to_vec::<f32>().unwrap();
/// assert!((0.65..1.3).contains(&direction[0]) && (-1.3..-0.65).contains(&direction[3]));
/// ```
pub fn orthogonalise(updates: Vec<Tensor<2>>) -> Vec<Tensor<2>> {
    updates.into_par_iter().map(orthogonalise_one).collect()
}

fn orthogonalise_one(update: Tensor<2>) -> Tensor<2> {
    let ([rows, columns], device, dtype) = (update.dims(), update.device(), update.dtype());
    if rows == 0 || columns == 0 {
        return update;
    }
    let values = update.cast(DType::F32).into_data().try_into_vec::<f32>();
    let mut values = values.expect("the precision it was cast to");
    iterate(&mut values, rows, columns);
    Tensor::from_data(TensorData::new(values, [rows, columns]), (&device, dtype))
}

/// With X tall, `A = Xᵀ X` and `X ← X (a I + b A + c A²)`; a wide X is transposed before and after.
fn iterate(values: &mut Vec<f32>, rows: usize, columns: usize) {
    let norm = values.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt();
    // Not `max`, which would hide a NaN.
    let scale = if norm < SMALLEST_NORM { SMALLEST_NORM } else { norm }.recip();
    for x in values.iter_mut() {
        *x = (f64::from(*x) * scale) as f32;
    }
    if rows < columns {
        *values = transposed(values, columns);
    }
    let size = rows.min(columns);
    let (mut first, mut square) = (Buffer::take(size * size), Buffer::take(size * size));
    let mut next = vec![0.0; values.len()];
    for _ in 0..ITERATIONS {
        gram(values, size, &mut first);
        // Symmetric, hence its own Gram matrix is its square.
        gram(&first, size, &mut square);
        polynomial(size, &first, &mut square);
        multiply(values, &Panels::new(&square, size), Start::Zero, &mut next);
        std::mem::swap(values, &mut next);
    }
    if rows < columns {
        *values = transposed(values, rows);
    }
}

vectorised! {
    /// `square = a I + b gram + c square`.
    fn polynomial<FUSED>(size: usize, gram: &[f32], square: &mut [f32]) {
        let [a, b, c] = COEFFICIENTS;
        for (x, g) in square.iter_mut().zip(gram) {
            *x = c * *x + b * g;
        }
        for x in square.iter_mut().step_by(size + 1) {
            *x += a;
        }
    }
}

/// Transpose of a matrix with rows of `columns` numbers.
pub(crate) fn transposed(matrix: &[f32], columns: usize) -> Vec<f32> {
    let rows = matrix.len() / columns.max(1);
    let mut result = Vec::with_capacity(matrix.len());
    for column in 0..columns {
        result.extend((0..rows).map(|row| matrix[row * columns + column]));
    }
    result
}

#[cfg(test)]
mod tests {
    use super::orthogonalise;
    use crate::testing::random;
    use burn::optim::{MuonConfig, Optimizer};
    use burn::tensor::{Device, Tensor};

    const SHAPES: [[usize; 2]; 5] = [[128, 128], [120, 128], [128, 40], [3, 70], [1, 1]];

    fn updates() -> Vec<Tensor<2>> {
        SHAPES.iter().zip(1..).map(|(shape, seed)| random(*shape, seed, &Device::flex())).collect()
    }

    fn numbers(x: Tensor<2>) -> Vec<f32> {
        x.into_data().try_to_vec().unwrap()
    }

    #[test]
    fn agrees_with_the_optimiser_of_burn() {
        for (update, ours) in updates().into_iter().zip(orthogonalise(updates())) {
            let [rows, columns] = update.dims();
            let start = Tensor::zeros([rows, columns], &update.device());
            let (moved, _) = MuonConfig::new().build().step::<2>(1.0, start, update, None);
            // Burn scales the step by √max(1, rows / columns) and subtracts it.
            let scale = -(rows as f32 / columns as f32).max(1.0).sqrt();
            for (ours, theirs) in numbers(ours).iter().zip(numbers(moved)) {
                assert!(
                    (ours * scale - theirs).abs() < 2e-5,
                    "{rows}x{columns}: {ours} vs {}",
                    theirs / scale
                );
            }
        }
    }

    #[test]
    fn singular_values_are_near_one() {
        // Rows of a wide matrix of random numbers: σ² are the Rayleigh quotients of X Xᵀ, sampled.
        for x in orthogonalise(updates()) {
            let [rows, columns] = x.dims();
            let x = if rows <= columns { x } else { x.transpose() };
            let probe = random([8, x.dims()[0]], 9, &x.device());
            let images = numbers(probe.clone().matmul(x).powi_scalar(2).sum_dim(1));
            for (image, length) in images.iter().zip(numbers(probe.powi_scalar(2).sum_dim(1))) {
                let singular = (image / length).sqrt();
                assert!((0.6..1.3).contains(&singular), "{rows}x{columns}: {singular}");
            }
        }
    }

    #[test]
    fn zero_stays_zero_and_not_a_number_stays_visible() {
        let device = Device::flex();
        let zero = Tensor::<2>::zeros([4, 6], &device);
        assert_eq!(numbers(orthogonalise(vec![zero.clone()]).remove(0)), [0.0; 24]);
        let broken = orthogonalise(vec![zero.slice_fill([1..2, 1..2], f32::NAN)]).remove(0);
        assert!(numbers(broken).iter().any(|x| x.is_nan()));
    }
}
