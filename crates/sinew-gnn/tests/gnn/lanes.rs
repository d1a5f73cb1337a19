//! A tensor as a number: a formula over [`Scalar`] becomes plain tensor operations.

use burn::tensor::Tensor;
use sinew_num::Scalar;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Many evaluations of one formula side by side: one lane per number of the tensor, such as per
/// element, or per sample and element.
///
/// Lanes of size one along an axis are repeated as needed, so `[samples, 1]` parameters meet
/// `[1, elements]` or `[samples, elements]` strains. Differentiable like any tensor; it is the
/// oracle of energies computed outside of Burn.
#[derive(Clone, Debug)]
pub(crate) struct Lanes<const D: usize>(pub Tensor<D>);

/// Beyond this distance from zero `eˣ − 1` loses no digits.
const EXP_M1_CANCELS: f64 = 1.0;

macro_rules! operator {
    ($trait:ident, $method:ident, $scalar:ident) => {
        impl<const D: usize> $trait for Lanes<D> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }

        impl<const D: usize> $trait<f64> for Lanes<D> {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                Self(self.0.$scalar(other))
            }
        }
    };
}

operator!(Add, add, add_scalar);
operator!(Sub, sub, sub_scalar);
operator!(Mul, mul, mul_scalar);
operator!(Div, div, div_scalar);

impl<const D: usize> Neg for Lanes<D> {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.neg())
    }
}

impl<const D: usize> Scalar for Lanes<D> {
    fn constant(&self, value: f64) -> Self {
        Self(self.0.full_like(value))
    }

    fn ln(self) -> Self {
        let outside = self.0.clone().lower_equal_scalar(0.0);
        Self(self.0.mask_fill(outside, 0.0).log())
    }

    fn ln_1p(self) -> Self {
        let outside = self.0.clone().lower_equal_scalar(-1.0);
        Self(self.0.mask_fill(outside, -1.0).log1p())
    }

    fn exp(self) -> Self {
        Self(self.0.exp())
    }

    /// `2 t / (1 − t)` with `t = tanh(x / 2)` near zero, where `eˣ − 1` would cancel.
    fn exp_m1(self) -> Self {
        let far = self.0.clone().abs().greater_scalar(EXP_M1_CANCELS);
        let t = self.0.clone().mask_fill(far.clone(), 0.0).div_scalar(2.0).tanh();
        let near = t.clone().mul_scalar(2.0) / (t.neg() + 1.0);
        Self(near.mask_where(far, self.0.exp() - 1.0))
    }

    fn tanh(self) -> Self {
        Self(self.0.tanh())
    }

    fn select_below(&self, threshold: f64, below: Self, otherwise: Self) -> Self {
        let (mut shape, parts) = (self.0.dims(), [below.0.dims(), otherwise.0.dims()]);
        for axis in 0..D {
            shape[axis] = shape[axis].max(parts[0][axis]).max(parts[1][axis]);
        }
        let is_below = self.0.clone().expand(shape).lower_scalar(threshold);
        Self(otherwise.0.expand(shape).mask_where(is_below, below.0.expand(shape)))
    }
}
