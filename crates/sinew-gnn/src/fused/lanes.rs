//! A tensor as a number: a formula over [`Scalar`] becomes plain tensor operations.

use burn::tensor::Tensor;
use sinew_num::Scalar;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Many evaluations of one formula side by side: one lane per number of the tensor, such as per
/// element, or per sample and element.
///
/// Lanes of size one along an axis are repeated as needed, so `[samples, 1]` parameters meet
/// `[1, elements]` or `[samples, elements]` strains. Differentiable like any tensor; it is the
/// oracle of energies computed outside of Burn ([`crate::fused::fused_potential`]).
///
/// ```
/// use burn::tensor::{Device, Tensor};
/// use sinew_gnn::fused::Lanes;
/// use sinew_num::Scalar;
///
/// fn energy<S: Scalar>(stretch: S) -> S {
///     (stretch.clone() * stretch.clone() - 1.0) * 0.5 - stretch.ln()
/// }
///
/// let stretch = Tensor::<1>::from_floats([1.0, 2.0], &Device::flex().autodiff()).require_grad();
/// let total = energy(Lanes(stretch.clone())).0.sum();
/// let slope = stretch.grad(&total.backward()).unwrap();
/// assert_eq!(slope.into_data().try_to_vec::<f32>().unwrap(), [0.0, 1.5]); // s − 1/s
/// ```
#[derive(Clone, Debug)]
pub struct Lanes<const D: usize>(pub Tensor<D>);

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

#[cfg(test)]
mod tests {
    use super::Lanes;
    use crate::fused::tests::device;
    use burn::tensor::{DType, Tensor, TensorData};
    use sinew_num::{Jet, Scalar};

    /// Uses every operation of a number.
    fn formula<S: Scalar>(x: S) -> S {
        let smooth = x.clone().exp() * 0.1 + x.clone().exp_m1() / (x.clone().squared() + 2.0);
        let logarithms = x.clone().at_least(0.25).ln() - x.clone().at_least(-0.5).ln_1p();
        let selected = x.select_below(0.3, -x.clone(), x.clone().tanh());
        smooth + logarithms * 0.5 + selected - x.constant(0.125) + x.at_most(1.0) - 0.5
    }

    #[test]
    fn lanes_agree_with_jets_in_double_precision() {
        let x: Vec<f64> = (0..60).map(|i| -3.0 + 0.1013 * f64::from(i)).collect();
        let device = device();
        let lanes = Tensor::<1>::from_data(TensorData::new(x.clone(), [60]), (&device, DType::F64))
            .require_grad();
        let y = formula(Lanes(lanes.clone())).0;
        let values = y.to_data().try_to_vec::<f64>().unwrap();
        let slopes =
            lanes.grad(&y.sum().backward()).unwrap().into_data().try_to_vec::<f64>().unwrap();
        for i in 0..x.len() {
            let jet = formula(Jet::<1>::variable(x[i], 0));
            // Rounding in double precision.
            assert!((values[i] - jet.value).abs() < 1e-13, "value at {}", x[i]);
            assert!((slopes[i] - jet.gradient[0]).abs() < 1e-12, "slope at {}", x[i]);
        }
    }

    #[test]
    fn single_precision_keeps_its_digits_near_zero() {
        let x = [1e-6_f32, -3e-5, 2e-3, 0.9, -0.9, 1.1, -20.0];
        let lanes = Lanes(Tensor::<1>::from_floats(x, &device()));
        let y = lanes.exp_m1().0.into_data().try_to_vec::<f32>().unwrap();
        for (x, y) in x.iter().zip(y) {
            let exact = f64::from(*x).exp_m1();
            assert!((f64::from(y) - exact).abs() <= 4e-7 * exact.abs(), "at {x}: {y} vs {exact}");
        }
    }

    #[test]
    fn logarithms_are_minus_infinity_outside_their_domain() {
        let lanes = |x: f32| Lanes(Tensor::<1>::from_floats([x], &device()));
        for x in [0.0, -1.0, -7.0] {
            assert_eq!(lanes(x).ln().0.into_scalar::<f32>(), f32::NEG_INFINITY);
            assert_eq!(lanes(x - 1.0).ln_1p().0.into_scalar::<f32>(), f32::NEG_INFINITY);
        }
    }

    #[test]
    fn parameters_per_sample_meet_strains_per_element() {
        let device = device();
        let stiffness = Lanes(Tensor::<2>::from_floats([[1.0], [2.0]], &device));
        let strain = Lanes(Tensor::<2>::from_floats([[0.5, 3.0, 4.0]], &device));
        let energy = strain.clone().select_below(1.0, stiffness.clone(), stiffness * strain);
        assert_eq!(
            energy.0.into_data().try_to_vec::<f32>().unwrap(),
            [1.0, 3.0, 4.0, 2.0, 6.0, 8.0]
        );
    }
}
