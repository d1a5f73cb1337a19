//! Truncated Taylor numbers: value, gradient and Hessian.

use crate::Scalar;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value with its gradient in `N` variables and `M` rows of its Hessian: all of them in a [`Jet`], none in a [`Slope`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taylor<const N: usize, const M: usize> {
    /// Value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; N],
    /// Second derivatives, symmetric.
    pub hessian: [[f64; N]; M],
}

/// A value with its gradient in `N` variables: one evaluation of an energy gives its stress.
pub type Slope<const N: usize> = Taylor<N, 0>;

/// A value with its gradient and Hessian in `N` variables: one evaluation of an energy in the
/// nine entries of ∇u gives stress and tangent.
pub type Jet<const N: usize> = Taylor<N, N>;

impl<const N: usize, const M: usize> Taylor<N, M> {
    /// A number that depends on no variable.
    pub fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; N], hessian: [[0.0; N]; M] }
    }

    /// The variable number `index`, at `value`.
    ///
    /// # Panics
    /// If `index` is not below `N`.
    pub fn variable(value: f64, index: usize) -> Self {
        let mut result = Self::constant(value);
        result.gradient[index] = 1.0;
        result
    }

    /// `f(self)` from the value and the first two derivatives of `f` at `self.value`.
    fn chain(mut self, f: f64, df: f64, ddf: f64) -> Self {
        let g = self.gradient;
        self.value = f;
        self.gradient.iter_mut().for_each(|g| *g *= df);
        for i in 0..M {
            for j in 0..N {
                self.hessian[i][j] = df * self.hessian[i][j] + ddf * g[i] * g[j];
            }
        }
        self
    }

    fn zip(mut self, right: Self, op: impl Fn(f64, f64) -> f64) -> Self {
        self.value = op(self.value, right.value);
        (0..N).for_each(|i| self.gradient[i] = op(self.gradient[i], right.gradient[i]));
        for i in 0..M {
            for j in 0..N {
                self.hessian[i][j] = op(self.hessian[i][j], right.hessian[i][j]);
            }
        }
        self
    }
}

macro_rules! linear {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const N: usize, const M: usize> $trait for Taylor<N, M> {
            type Output = Self;
            fn $method(self, right: Self) -> Self {
                self.zip(right, |a, b| a $op b)
            }
        }
        impl<const N: usize, const M: usize> $trait<f64> for Taylor<N, M> {
            type Output = Self;
            fn $method(self, right: f64) -> Self {
                Self { value: self.value $op right, ..self }
            }
        }
    };
}
linear!(Add, add, +);
linear!(Sub, sub, -);

impl<const N: usize, const M: usize> Mul for Taylor<N, M> {
    type Output = Self;
    fn mul(self, right: Self) -> Self {
        let mut result = Self::constant(self.value * right.value);
        for i in 0..N {
            result.gradient[i] = self.gradient[i] * right.value + self.value * right.gradient[i];
        }
        for i in 0..M {
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

/// Division goes through the reciprocal's chain rule.
impl<const N: usize, const M: usize> Div for Taylor<N, M> {
    type Output = Self;
    fn div(self, right: Self) -> Self {
        let r = right.value.recip();
        self * right.chain(r, -r * r, 2.0 * r * r * r)
    }
}

impl<const N: usize, const M: usize> Neg for Taylor<N, M> {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize, const M: usize> Mul<f64> for Taylor<N, M> {
    type Output = Self;
    fn mul(mut self, right: f64) -> Self {
        self.value *= right;
        self.gradient.iter_mut().for_each(|g| *g *= right);
        self.hessian.as_flattened_mut().iter_mut().for_each(|h| *h *= right);
        self
    }
}

impl<const N: usize, const M: usize> Scalar for Taylor<N, M> {
    fn constant(&self, value: f64) -> Self {
        Self::constant(value)
    }
    fn ln(self) -> Self {
        let x = self.value;
        self.chain(Scalar::ln(x), x.recip(), -(x * x).recip())
    }
    fn ln_1p(self) -> Self {
        let x = self.value;
        let r = (1.0 + x).recip();
        self.chain(Scalar::ln_1p(x), r, -r * r)
    }
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e, e)
    }
    fn exp_m1(self) -> Self {
        let x = self.value;
        let e = x.exp();
        self.chain(x.exp_m1(), e, e)
    }
    fn tanh(self) -> Self {
        let t = self.value.tanh();
        let slope = 1.0 - t * t;
        self.chain(t, slope, -2.0 * t * slope)
    }
    fn select_below(&self, threshold: f64, below: Self, otherwise: Self) -> Self {
        if self.value < threshold { below } else { otherwise }
    }
    fn branch_below(
        &self,
        threshold: f64,
        below: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self {
        if self.value < threshold { below() } else { otherwise() }
    }
}
