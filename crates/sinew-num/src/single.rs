//! Single precision.

use crate::Scalar;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// An `f32` as a [`Scalar`]: what a formula loses in single precision, as tensors of an emulator have it.
///
/// A type of its own, because `f32 + f64` cannot be defined outside the standard library.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Single(pub f32);

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Single {
            type Output = Self;
            fn $method(self, right: Self) -> Self {
                Self(self.0 $op right.0)
            }
        }
        impl $trait<f64> for Single {
            type Output = Self;
            fn $method(self, right: f64) -> Self {
                Self(self.0 $op right as f32)
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Single {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Scalar for Single {
    fn constant(&self, value: f64) -> Self {
        Self(value as f32)
    }
    fn ln(self) -> Self {
        Self(if self.0 <= 0.0 { f32::NEG_INFINITY } else { self.0.ln() })
    }
    fn ln_1p(self) -> Self {
        Self(if self.0 <= -1.0 { f32::NEG_INFINITY } else { self.0.ln_1p() })
    }
    fn exp(self) -> Self {
        Self(self.0.exp())
    }
    fn exp_m1(self) -> Self {
        Self(self.0.exp_m1())
    }
    fn tanh(self) -> Self {
        Self(self.0.tanh())
    }
    fn select_below(&self, threshold: f64, below: Self, otherwise: Self) -> Self {
        if self.0 < threshold as f32 { below } else { otherwise }
    }
}
