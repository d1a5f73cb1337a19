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
fn celu<const FUSED: bool>(x: f32) -> f32 {
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
fn tanh<const FUSED: bool>(x: f32) -> f32 {
    let e = exp_m1::<FUSED>((2.0 * x).clamp(-TANH_SATURATES, TANH_SATURATES));
    e / (e + 2.0)
}

#[inline(always)]
fn tanh_slope<const FUSED: bool>(value: f32) -> f32 {
    multiply_add::<FUSED>(-value, value, 1.0)
}

/// Evaluates `$body` with `$value` and `$slope` bound to one activation's functions.
macro_rules! for_activation {
    ($activation:expr, $fused:ident, |$value:ident, $slope:ident| $body:expr) => {
        match $activation {
            Activation::Celu => {
                #[allow(unused_variables)]
                let ($value, $slope) = (celu::<$fused>, celu_slope);
                $body
            }
            Activation::Tanh => {
                #[allow(unused_variables)]
                let ($value, $slope) = (tanh::<$fused>, tanh_slope::<$fused>);
                $body
            }
        }
    };
}

vectorised! {
    /// `x = f(x)` for every number.
    pub(crate) fn activate<FUSED>(activation: Activation, x: &mut [f32]) {
        for_activation!(activation, FUSED, |value, slope| {
            for x in x {
                *x = value(*x);
            }
        })
    }
}

vectorised! {
    /// `x = f(x + bias)` for every row of `x`.
    pub(crate) fn add_bias_and_activate<FUSED>(activation: Activation, bias: &[f32], x: &mut [f32]) {
        for_activation!(activation, FUSED, |value, slope| {
            for row in x.chunks_exact_mut(bias.len()) {
                for (x, b) in row.iter_mut().zip(bias) {
                    *x = value(*x + b);
                }
            }
        })
    }
}

vectorised! {
    /// `output[i] = cotangent[i] · f'`, the derivative taken from the activation's `value`.
    pub(crate) fn pull_back<FUSED>(activation: Activation, value: &[f32], cotangent: &[f32], output: &mut [f32]) {
        for_activation!(activation, FUSED, |f, slope| {
            for ((d, c), y) in output.iter_mut().zip(cotangent).zip(value) {
                *d = c * slope(*y);
            }
        })
    }
}

vectorised! {
    /// `cotangent *= f'` in place, and adds its rows to `bias_gradient`.
    pub(crate) fn pull_back_rows<FUSED>(
        activation: Activation,
        value: &[f32],
        cotangent: &mut [f32],
        bias_gradient: &mut [f32],
    ) {
        let width = bias_gradient.len();
        for_activation!(activation, FUSED, |f, slope| {
            for (row, y) in cotangent.chunks_exact_mut(width).zip(value.chunks_exact(width)) {
                for ((d, y), sum) in row.iter_mut().zip(y).zip(bias_gradient.iter_mut()) {
                    *d *= slope(*y);
                    *sum += *d;
                }
            }
        })
    }
}

vectorised! {
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
        for_activation!(activation, FUSED, |f, slope| {
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

#[cfg(test)]
mod tests {
    use super::{Activation, activate, pull_back};

    /// Rounding of the polynomial and of `2ⁿ − 1`, a few units in the last place.
    const TOLERANCE: f64 = 4e-7;

    fn exact(activation: Activation, x: f64) -> (f64, f64) {
        match activation {
            Activation::Celu if x > 0.0 => (x, 1.0),
            Activation::Celu => (x.exp_m1(), x.exp()),
            Activation::Tanh => (x.tanh(), 1.0 - x.tanh().powi(2)),
        }
    }

    #[test]
    fn values_and_slopes_match_double_precision() {
        let x: Vec<f32> = (-4000..4000).map(|i| i as f32 * 2.3e-3).collect();
        let mut d = vec![0.0; x.len()];
        for activation in [Activation::Celu, Activation::Tanh] {
            let mut y = x.clone();
            activate(activation, &mut y);
            pull_back(activation, &y, &vec![1.0; x.len()], &mut d);
            for i in 0..x.len() {
                let (value, slope) = exact(activation, f64::from(x[i]));
                assert!(
                    (f64::from(y[i]) - value).abs() <= TOLERANCE * value.abs(),
                    "{activation:?}({})",
                    x[i]
                );
                assert!((f64::from(d[i]) - slope).abs() <= TOLERANCE, "{activation:?}'({})", x[i]);
            }
        }
    }

    #[test]
    fn limits_and_not_a_number() {
        let x = [f32::NEG_INFINITY, -1e30, -0.0, 0.0, 1e30, f32::INFINITY, f32::NAN];
        let mut y = x;
        activate(Activation::Celu, &mut y);
        assert_eq!(y[..6], [-1.0, -1.0, 0.0, 0.0, 1e30, f32::INFINITY]);
        assert!(y[6].is_nan());
        let mut y = x;
        activate(Activation::Tanh, &mut y);
        assert_eq!(y[..6], [-1.0, -1.0, 0.0, 0.0, 1.0, 1.0]);
        assert!(y[6].is_nan());
    }
}
