//! Arithmetic of series with series and numbers.

use super::Series;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A binary operator on all combinations of values and references, of two series or of one and a number on either side.
macro_rules! operator {
    ($trait:ident, $method:ident, |$left:ident, $right:ident| $body:expr) => {
        operator!(@ $trait, $method, Series, Series, |$left, $right| $body);
        operator!(@ $trait, $method, Series, &Series, |$left, $right| $body);
        operator!(@ $trait, $method, &Series, Series, |$left, $right| $body);
        operator!(@ $trait, $method, &Series, &Series, |$left, $right| $body);
    };
    ($trait:ident, $method:ident, number |$a:ident, $b:ident| $after:expr, |$c:ident, $d:ident| $before:expr) => {
        operator!(@ $trait, $method, Series, f64, |$a, $b| $after);
        operator!(@ $trait, $method, &Series, f64, |$a, $b| $after);
        operator!(@ $trait, $method, f64, Series, |$c, $d| $before);
        operator!(@ $trait, $method, f64, &Series, |$c, $d| $before);
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
operator!(Add, add, number | l, r | l.plus(*r), |l, r| r.plus(*l));
operator!(Sub, sub, number | l, r | l.plus(-r), |l, r| r.map(|c| -c).plus(*l));
operator!(Mul, mul, number | l, r | l.map(|c| c * r), |l, r| r.map(|c| c * l));
operator!(Div, div, number | l, r | l.map(|c| c / r), |l, r| r.recip().map(|c| c * l));

impl Neg for &Series {
    type Output = Series;
    fn neg(self) -> Series {
        self.map(|c| -c)
    }
}

impl Neg for Series {
    type Output = Self;
    fn neg(self) -> Self {
        -&self
    }
}
