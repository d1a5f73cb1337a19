//! Activation functions whose derivative is a function of their value.

use crate::fused::simd::{exp_m1, multiply_add, vectorised};
use serde::{Deserialize, Serialize};

/// Nonlinearity of the hidden layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// Continuously differentiable exponential linear unit, `max(0, x) + min(0, eˣ − 1)` (Barron 2017 with α = 1; thesis, chapter 3).
    #[default]
    Celu,
    /// Hyperbolic tangent (thesis, chapter 2).
    Tanh,
}

/// Below this, `eˣ − 1` is −1 in single precision, and `2ⁿ` would leave the normal numbers.
const LOWEST_EXPONENT: f32 = -87.0;
/// Beyond this, `tanh(x / 2)` is ±1 in single precision.
const TANH_SATURATES: f32 = 20.0;

#[inline(always)]
pub(crate) fn celu<const FUSED: bool>(x: f32) -> f32 {
    // The comparisons are written so that NaN passes through.
    let negative = if x < LOWEST_EXPONENT { LOWEST_EXPONENT } else { x };
    let negative = if negative > 0.0 { 0.0 } else { negative };
    let curved = exp_m1::<FUSED>(negative);
    if x > 0.0 { x } else { curved }
}

#[inline(always)]
fn celu_slope(value: f32) -> f32 {
    if value > 0.0 { 1.0 } else { value + 1.0 }
}

#[inline(always)]
pub(crate) fn tanh<const FUSED: bool>(x: f32) -> f32 {
    let e = exp_m1::<FUSED>((2.0 * x).clamp(-TANH_SATURATES, TANH_SATURATES));
    e / (e + 2.0)
}

#[inline(always)]
fn tanh_slope<const FUSED: bool>(value: f32) -> f32 {
    multiply_add::<FUSED>(-value, value, 1.0)
}

/// Evaluates `$body` with `$f` bound to the function that belongs to an activation.
macro_rules! for_activation {
    ($activation:expr, $celu:expr, $tanh:expr, |$f:ident| $body:expr) => {
        match $activation {
            Activation::Celu => {
                let $f = $celu;
                $body
            }
            Activation::Tanh => {
                let $f = $tanh;
                $body
            }
        }
    };
}
pub(crate) use for_activation;

vectorised! {
    /// `x = f(x)` for every number.
    pub(crate) fn activate<FUSED>(activation: Activation, x: &mut [f32]) {
        for_activation!(activation, celu::<FUSED>, tanh::<FUSED>, |value| {
            for x in x {
                *x = value(*x);
            }
        })
    }

    /// `x = f(x + bias)` for every row of `x`.
    pub(crate) fn add_bias_and_activate<FUSED>(activation: Activation, bias: &[f32], x: &mut [f32]) {
        for_activation!(activation, celu::<FUSED>, tanh::<FUSED>, |value| {
            for row in x.chunks_exact_mut(bias.len()) {
                for (x, b) in row.iter_mut().zip(bias) {
                    *x = value(*x + b);
                }
            }
        })
    }

    /// `output[i] = cotangent[i] · f'`, the derivative taken from the activation's `value`.
    pub(crate) fn pull_back<FUSED>(activation: Activation, value: &[f32], cotangent: &[f32], output: &mut [f32]) {
        for_activation!(activation, celu_slope, tanh_slope::<FUSED>, |slope| {
            for ((d, c), y) in output.iter_mut().zip(cotangent).zip(value) {
                *d = c * slope(*y);
            }
        })
    }

    /// `cotangent *= f'` in place, and adds its rows to `bias_gradient`.
    pub(crate) fn pull_back_rows<FUSED>(
        activation: Activation,
        value: &[f32],
        cotangent: &mut [f32],
        bias_gradient: &mut [f32],
    ) {
        let width = bias_gradient.len();
        for_activation!(activation, celu_slope, tanh_slope::<FUSED>, |slope| {
            for (row, y) in cotangent.chunks_exact_mut(width).zip(value.chunks_exact(width)) {
                for ((d, y), sum) in row.iter_mut().zip(y).zip(bias_gradient.iter_mut()) {
                    *d *= slope(*y);
                    *sum += *d;
                }
            }
        })
    }

    /// Pull-back through a last layer with one output: with h = `value`, c = `cotangent` and w =
    /// `weight`, `output[r] = c[r] w f'(h[r])`, whose rows are added to `bias_gradient`, and
    /// `weight_gradient += Σ c[r] h[r]`.
    pub(crate) fn pull_back_single_output<FUSED>(
        activation: Activation,
        value: &[f32],
        cotangent: &[f32],
        weight: &[f32],
        output: &mut [f32],
        bias_gradient: &mut [f32],
        weight_gradient: &mut [f32],
    ) {
        let width = weight.len();
        let (bias_gradient, weight_gradient) = (&mut bias_gradient[..width], &mut weight_gradient[..width]);
        for_activation!(activation, celu_slope, tanh_slope::<FUSED>, |slope| {
            for ((row, h), c) in output.chunks_exact_mut(width).zip(value.chunks_exact(width)).zip(cotangent) {
                for j in 0..width {
                    let d = c * weight[j] * slope(h[j]);
                    row[j] = d;
                    bias_gradient[j] += d;
                    weight_gradient[j] = multiply_add::<FUSED>(*c, h[j], weight_gradient[j]);
                }
            }
        })
    }
}
