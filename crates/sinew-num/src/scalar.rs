//! The operations a formula may use.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or a bundle of numbers, that a strain-energy law is evaluated over.
///
/// Implementations: `f64` and [`crate::Single`] (value), [`crate::Slope`] (value and gradient), [`crate::Jet`] (value,
/// gradient and Hessian), and a tensor lane type in `sinew-gnn` (the values of many elements).
/// Not `Copy`, because tensors are not.
pub trait Scalar:
    Clone
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// The constant `value`, shaped like `self`.
    fn constant(&self, value: f64) -> Self;
    /// Natural logarithm; −∞ at zero and below, so that an energy in −ln J is +∞ there.
    fn ln(self) -> Self;
    /// `ln(1 + self)` without cancellation near zero; −∞ at −1 and below.
    fn ln_1p(self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
    /// `exp(self) − 1` without cancellation near zero.
    fn exp_m1(self) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// `below` where `self < threshold`, `otherwise` elsewhere; lane by lane for tensors.
    ///
    /// Both branches are evaluated, and an infinite one that is not taken does not leak into
    /// value or derivatives for `f64` and jets; for tensors the caller keeps both finite.
    fn select_below(&self, threshold: f64, below: Self, otherwise: Self) -> Self;

    /// [`Scalar::select_below`] with branches that a plain number evaluates only where it takes them.
    fn branch_below(
        &self,
        threshold: f64,
        below: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self {
        self.select_below(threshold, below(), otherwise())
    }

    /// `self²`.
    fn squared(self) -> Self {
        self.clone() * self
    }

    /// The larger of `self` and `floor`, with derivative zero below it.
    fn at_least(self, floor: f64) -> Self {
        self.select_below(floor, self.constant(floor), self.clone())
    }

    /// The smaller of `self` and `cap`, with derivative zero above it.
    fn at_most(self, cap: f64) -> Self {
        self.select_below(cap, self.clone(), self.constant(cap))
    }
}

impl Scalar for f64 {
    fn constant(&self, value: f64) -> Self {
        value
    }
    fn ln(self) -> Self {
        if self <= 0.0 { f64::NEG_INFINITY } else { f64::ln(self) }
    }
    fn ln_1p(self) -> Self {
        if self <= -1.0 { f64::NEG_INFINITY } else { f64::ln_1p(self) }
    }
    fn exp(self) -> Self {
        f64::exp(self)
    }
    fn exp_m1(self) -> Self {
        f64::exp_m1(self)
    }
    fn tanh(self) -> Self {
        f64::tanh(self)
    }
    fn select_below(&self, threshold: f64, below: Self, otherwise: Self) -> Self {
        if *self < threshold { below } else { otherwise }
    }
    fn branch_below(
        &self,
        threshold: f64,
        below: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self {
        if *self < threshold { below() } else { otherwise() }
    }
}

/// Variables and operators shared by the truncated Taylor types: sums, those with a plain number on the right, and
/// division through the reciprocal's chain rule.
macro_rules! taylor_operators {
    ($name:ident) => {
        impl<const N: usize> $name<N> {
            /// The variable number `index`, at `value`.
            ///
            /// # Panics
            /// If `index` is not below `N`.
            pub fn variable(value: f64, index: usize) -> Self {
                let mut result = Self::constant(value);
                result.gradient[index] = 1.0;
                result
            }
        }
        impl<const N: usize> std::ops::Add for $name<N> {
            type Output = Self;
            fn add(self, right: Self) -> Self {
                self.zip(right, |a, b| a + b)
            }
        }
        impl<const N: usize> std::ops::Sub for $name<N> {
            type Output = Self;
            fn sub(self, right: Self) -> Self {
                self.zip(right, |a, b| a - b)
            }
        }
        impl<const N: usize> std::ops::Add<f64> for $name<N> {
            type Output = Self;
            fn add(mut self, right: f64) -> Self {
                self.value += right;
                self
            }
        }
        impl<const N: usize> std::ops::Sub<f64> for $name<N> {
            type Output = Self;
            fn sub(mut self, right: f64) -> Self {
                self.value -= right;
                self
            }
        }
        impl<const N: usize> std::ops::Neg for $name<N> {
            type Output = Self;
            fn neg(self) -> Self {
                self * -1.0
            }
        }
        impl<const N: usize> std::ops::Div for $name<N> {
            type Output = Self;
            fn div(self, right: Self) -> Self {
                let r = right.value.recip();
                self * right.chain(r, -r * r, 2.0 * r * r * r)
            }
        }
        impl<const N: usize> $crate::Scalar for $name<N> {
            fn constant(&self, value: f64) -> Self {
                Self::constant(value)
            }
            fn ln(self) -> Self {
                let x = self.value;
                self.chain($crate::Scalar::ln(x), x.recip(), -(x * x).recip())
            }
            fn ln_1p(self) -> Self {
                let x = self.value;
                let r = (1.0 + x).recip();
                self.chain($crate::Scalar::ln_1p(x), r, -r * r)
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
    };
}
pub(crate) use taylor_operators;
