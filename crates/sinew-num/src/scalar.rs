//! The operations a formula may use.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or a bundle of numbers, that a strain-energy law is evaluated over.
///
/// Implementations: `f64` (value), [`crate::Slope`] (value and gradient), [`crate::Jet`] (value,
/// gradient and Hessian), and a tensor lane type in the tests of `sinew-gnn` (the values of many elements).
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
