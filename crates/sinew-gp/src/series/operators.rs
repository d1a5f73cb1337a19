//! Arithmetic of series with series and numbers.

use super::Series;
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
