//! Second-order Taylor numbers: value, gradient and Hessian.

use crate::scalar::taylor_operators;
use std::ops::Mul;

/// A value with its gradient and Hessian in `N` variables: one evaluation of an energy in the
/// nine entries of ∇u gives stress and tangent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<const N: usize> {
    /// Value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; N],
    /// Second derivatives, symmetric.
    pub hessian: [[f64; N]; N],
}

impl<const N: usize> Jet<N> {
    /// A number that depends on no variable.
    pub fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; N], hessian: [[0.0; N]; N] }
    }

    /// `f(self)` from the value and the first two derivatives of `f` at `self.value`.
    pub(crate) fn chain(mut self, f: f64, df: f64, ddf: f64) -> Self {
        let g = self.gradient;
        self.value = f;
        for i in 0..N {
            self.gradient[i] *= df;
            for j in 0..N {
                self.hessian[i][j] = df * self.hessian[i][j] + ddf * g[i] * g[j];
            }
        }
        self
    }

    fn zip(mut self, right: Self, op: impl Fn(f64, f64) -> f64) -> Self {
        self.value = op(self.value, right.value);
        for i in 0..N {
            self.gradient[i] = op(self.gradient[i], right.gradient[i]);
            for j in 0..N {
                self.hessian[i][j] = op(self.hessian[i][j], right.hessian[i][j]);
            }
        }
        self
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Self;
    fn mul(self, right: Self) -> Self {
        let mut result = Self::constant(self.value * right.value);
        for i in 0..N {
            result.gradient[i] = self.gradient[i] * right.value + self.value * right.gradient[i];
            for j in 0..N {
                result.hessian[i][j] = self.hessian[i][j] * right.value
                    + self.value * right.hessian[i][j]
                    + self.gradient[i] * right.gradient[j]
                    + self.gradient[j] * right.gradient[i];
            }
        }
        result
    }
}

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Self;
    fn mul(mut self, right: f64) -> Self {
        self.value *= right;
        self.gradient.iter_mut().for_each(|g| *g *= right);
        self.hessian.as_flattened_mut().iter_mut().for_each(|h| *h *= right);
        self
    }
}

taylor_operators!(Jet);
