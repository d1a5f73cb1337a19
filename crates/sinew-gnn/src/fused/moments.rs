//! Inner loops of optimisers: running moments of gradients, and the Newton–Schulz iteration of Muon.

use crate::fused::pool::Buffer;
use crate::fused::product::{Panels, Start, gram, multiply};
use crate::fused::simd::{multiply_add, vectorised};

/// Rule that turns a gradient into a direction of change, for one step of Adam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdamRule {
    /// Decay of the first moment.
    pub beta1: f32,
    /// Decay of the second moment.
    pub beta2: f32,
    /// Factor of the first moment in the direction: the bias correction.
    pub of_first: f32,
    /// Factor of the gradient itself in the direction; zero without Nesterov's look ahead.
    pub of_gradient: f32,
    /// Factor of the second moment under the root: the bias correction.
    pub of_second: f32,
}

/// Added to the root of Adam's second moment.
const EPSILON: f32 = 1e-8;

vectorised! {
    /// Updates both moments and replaces `gradient` by the direction of change
    /// `(of_first m + of_gradient g) / (√(of_second v) + 1e-8)`.
    ///
    /// ```
    /// use sinew_gnn::fused::{AdamRule, adam_direction};
    ///
    /// let rule = AdamRule { beta1: 0.9, beta2: 0.999, of_first: 10.0, of_gradient: 0.0, of_second: 1e3 };
    /// let (mut m, mut v, mut g) = ([0.0], [0.0], [-3.0]);
    /// adam_direction(rule, &mut m, &mut v, &mut g);
    /// assert!((g[0] + 1.0).abs() < 1e-4); // the first step has the gradient's sign
    /// ```
    pub fn adam_direction<FUSED>(rule: AdamRule, first: &mut [f32], second: &mut [f32], gradient: &mut [f32]) {
        let AdamRule { beta1, beta2, of_first, of_gradient, of_second } = rule;
        for ((m, v), g) in first.iter_mut().zip(second).zip(gradient) {
            *m = multiply_add::<FUSED>(beta1, *m, (1.0 - beta1) * *g);
            *v = multiply_add::<FUSED>(beta2, *v, (1.0 - beta2) * *g * *g);
            let ahead = multiply_add::<FUSED>(of_first, *m, of_gradient * *g);
            *g = ahead / ((of_second * *v).sqrt() + EPSILON);
        }
    }

    /// `momentum = decay · momentum + (1 − decay) gradient`, and replaces `gradient` by
    /// `of_momentum · momentum + of_gradient · gradient`.
    pub fn momentum_direction<FUSED>(
        decay: f32,
        of_momentum: f32,
        of_gradient: f32,
        momentum: &mut [f32],
        gradient: &mut [f32],
    ) {
        for (m, g) in momentum.iter_mut().zip(gradient) {
            *m = multiply_add::<FUSED>(decay, *m, (1.0 - decay) * *g);
            *g = multiply_add::<FUSED>(of_momentum, *m, of_gradient * *g);
        }
    }

    /// `x = x − step · direction`.
    pub fn descend<FUSED>(step: f32, direction: &[f32], x: &mut [f32]) {
        for (x, d) in x.iter_mut().zip(direction) {
            *x -= step * *d;
        }
    }
}

/// Iterations; five bring singular values from 10⁻² to near one.
const ITERATIONS: usize = 5;
/// Coefficients of `σ ↦ a σ + b σ³ + c σ⁵`, which has the steepest slope at zero among those
/// that map [0, 1] near one (Jordan et al., Muon, 2024).
const COEFFICIENTS: [f32; 3] = [3.4445, -4.775, 2.0315];
/// Norm below which a matrix counts as zero and is left small.
const SMALLEST_NORM: f64 = 1e-7;

/// Replaces a matrix `U S Vᵀ`, whose rows have `columns` numbers, by nearly `U Vᵀ`, with singular values between about 0.7 and 1.2:
/// the update direction of Muon. Zero stays zero. Newton–Schulz steps: with X tall, `A = Xᵀ X` and `X ← X (a I + b A + c A²)`; a wide X is
/// transposed before and after.
///
/// ```
/// let mut update = vec![3.0, 0.0, 0.0, -1e-1];
/// sinew_gnn::fused::orthogonalise(&mut update, 2);
/// assert!((0.65..1.3).contains(&update[0]) && (-1.3..-0.65).contains(&update[3]));
/// ```
pub fn orthogonalise(values: &mut Vec<f32>, columns: usize) {
    if values.is_empty() {
        return;
    }
    let rows = values.len() / columns;
    let norm = squared_norm(values).sqrt();
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

/// Sum of squares in interleaved partial sums, which the compiler turns into vectors.
pub(crate) fn squared_norm(values: &[f32]) -> f64 {
    let mut lanes = [0.0; 8];
    for chunk in values.chunks(lanes.len()) {
        for (lane, value) in lanes.iter_mut().zip(chunk) {
            *lane += f64::from(*value) * f64::from(*value);
        }
    }
    lanes.iter().sum()
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
