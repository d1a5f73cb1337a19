//! Arithmetic of series with series and numbers, and series as the numbers of a formula.

use super::Series;
use crate::Scalar;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A binary operator on all combinations of values and references.
macro_rules! operator {
    ($trait:ident, $method:ident, |$left:ident, $right:ident| $body:expr) => {
        operator!(@ $trait, $method, Series, Series, |$left, $right| $body);
        operator!(@ $trait, $method, Series, &Series, |$left, $right| $body);
        operator!(@ $trait, $method, &Series, Series, |$left, $right| $body);
        operator!(@ $trait, $method, &Series, &Series, |$left, $right| $body);
    };
    (@ $trait:ident, $method:ident, $Left:ty, $Right:ty, |$left:ident, $right:ident| $body:expr) => {
        impl $trait<$Right> for $Left {
            type Output = Series;
            fn $method(self, right: $Right) -> Series {
                let ($left, $right) = (&self, &right);
                $body
            }
        }
    };
}

operator!(Add, add, |l, r| l.zip(r, |a, b| a + b));
operator!(Sub, sub, |l, r| l.zip(r, |a, b| a - b));
operator!(Mul, mul, |l, r| l.product(r));
operator!(Div, div, |l, r| l.product(&r.recip()));

/// An operator with a plain number on either side.
macro_rules! operator_with_number {
    ($Left:ty) => {
        impl Add<f64> for $Left {
            type Output = Series;
            fn add(self, right: f64) -> Series {
                let mut result = self.clone();
                result.coefficients[0] += right;
                result
            }
        }
        impl Sub<f64> for $Left {
            type Output = Series;
            fn sub(self, right: f64) -> Series {
                self + -right
            }
        }
        impl Mul<f64> for $Left {
            type Output = Series;
            fn mul(self, right: f64) -> Series {
                self.map(|c| c * right)
            }
        }
        impl Div<f64> for $Left {
            type Output = Series;
            fn div(self, right: f64) -> Series {
                self.map(|c| c / right)
            }
        }
        impl Neg for $Left {
            type Output = Series;
            fn neg(self) -> Series {
                self.map(|c| -c)
            }
        }
        impl Add<$Left> for f64 {
            type Output = Series;
            fn add(self, right: $Left) -> Series {
                right + self
            }
        }
        impl Sub<$Left> for f64 {
            type Output = Series;
            fn sub(self, right: $Left) -> Series {
                -right + self
            }
        }
        impl Mul<$Left> for f64 {
            type Output = Series;
            fn mul(self, right: $Left) -> Series {
                right * self
            }
        }
        impl Div<$Left> for f64 {
            type Output = Series;
            fn div(self, right: $Left) -> Series {
                Mul::mul(right.recip(), self)
            }
        }
    };
}
operator_with_number!(Series);
operator_with_number!(&Series);

impl Scalar for Series {
    fn constant(&self, value: f64) -> Self {
        Series::constant(self, value)
    }
    fn ln(self) -> Self {
        Series::ln(&self)
    }
    fn ln_1p(self) -> Self {
        let x = self.coefficients[0];
        self.logarithm(Scalar::ln_1p(x), 1.0 + x)
    }
    fn exp(self) -> Self {
        Series::exp(&self)
    }
    fn exp_m1(self) -> Self {
        let mut result = Series::exp(&self);
        result.coefficients[0] = self.coefficients[0].exp_m1();
        result
    }
    fn tanh(self) -> Self {
        Series::tanh(&self)
    }
    fn select_below(&self, threshold: f64, below: Self, otherwise: Self) -> Self {
        if self.value() < threshold { below } else { otherwise }
    }
    fn branch_below(
        &self,
        threshold: f64,
        below: impl FnOnce() -> Self,
        otherwise: impl FnOnce() -> Self,
    ) -> Self {
        if self.value() < threshold { below() } else { otherwise() }
    }
}
