//! First-order Taylor numbers: value and gradient.

use crate::scalar::taylor_operators;
use std::ops::Mul;

/// A value with its gradient in `N` variables: one evaluation of an energy gives its stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope<const N: usize> {
    /// Value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; N],
}

impl<const N: usize> Slope<N> {
    /// A number that depends on no variable.
    pub fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; N] }
    }

    /// `f(self)` from the value and first derivative of `f`; the second one is not needed.
    pub(crate) fn chain(mut self, f: f64, df: f64, _ddf: f64) -> Self {
        self.value = f;
        self.gradient.iter_mut().for_each(|g| *g *= df);
        self
    }

    fn zip(mut self, right: Self, op: impl Fn(f64, f64) -> f64) -> Self {
        self.value = op(self.value, right.value);
        (0..N).for_each(|i| self.gradient[i] = op(self.gradient[i], right.gradient[i]));
        self
    }
}

#[expect(clippy::suspicious_arithmetic_impl, reason = "product rule")]
impl<const N: usize> Mul for Slope<N> {
    type Output = Self;
    fn mul(self, right: Self) -> Self {
        Self {
            value: self.value * right.value,
            gradient: std::array::from_fn(|i| {
                self.gradient[i] * right.value + self.value * right.gradient[i]
            }),
        }
    }
}

impl<const N: usize> Mul<f64> for Slope<N> {
    type Output = Self;
    fn mul(mut self, right: f64) -> Self {
        self.value *= right;
        self.gradient.iter_mut().for_each(|g| *g *= right);
        self
    }
}

taylor_operators!(Slope);
