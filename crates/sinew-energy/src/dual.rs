//! Numbers with one derivative, over any number.

use sinew_num::Scalar;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `value + ε derivative` with `ε² = 0`. Over a [`sinew_num::Slope`] it gives the mixed derivatives of an
/// energy in the strain and one parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dual<S> {
    pub value: S,
    pub derivative: S,
}

impl<S: Scalar> Dual<S> {
    fn chain(self, f: S, df: S) -> Self {
        Self { value: f, derivative: self.derivative * df }
    }
}

impl<S: Scalar> Add for Dual<S> {
    type Output = Self;
    fn add(self, right: Self) -> Self {
        Self { value: self.value + right.value, derivative: self.derivative + right.derivative }
    }
}

impl<S: Scalar> Sub for Dual<S> {
    type Output = Self;
    fn sub(self, right: Self) -> Self {
        Self { value: self.value - right.value, derivative: self.derivative - right.derivative }
    }
}

impl<S: Scalar> Mul for Dual<S> {
    type Output = Self;
    fn mul(self, right: Self) -> Self {
        let derivative =
            self.derivative * right.value.clone() + self.value.clone() * right.derivative;
        Self { value: self.value * right.value, derivative }
    }
}

impl<S: Scalar> Div for Dual<S> {
    type Output = Self;
    fn div(self, right: Self) -> Self {
        let value = self.value / right.value.clone();
        let derivative = (self.derivative - value.clone() * right.derivative) / right.value;
        Self { value, derivative }
    }
}

impl<S: Scalar> Neg for Dual<S> {
    type Output = Self;
    fn neg(self) -> Self {
        Self { value: -self.value, derivative: -self.derivative }
    }
}

impl<S: Scalar> Add<f64> for Dual<S> {
    type Output = Self;
    fn add(self, right: f64) -> Self {
        Self { value: self.value + right, ..self }
    }
}

impl<S: Scalar> Sub<f64> for Dual<S> {
    type Output = Self;
    fn sub(self, right: f64) -> Self {
        Self { value: self.value - right, ..self }
    }
}

impl<S: Scalar> Mul<f64> for Dual<S> {
    type Output = Self;
    fn mul(self, right: f64) -> Self {
        Self { value: self.value * right, derivative: self.derivative * right }
    }
}

impl<S: Scalar> Scalar for Dual<S> {
    fn constant(&self, value: f64) -> Self {
        Self { value: self.value.constant(value), derivative: self.value.constant(0.0) }
    }
    fn ln(self) -> Self {
        let value = self.value.clone();
        Self { derivative: self.derivative / value.clone(), value: value.ln() }
    }
    fn ln_1p(self) -> Self {
        let value = self.value.clone();
        Self { derivative: self.derivative / (value.clone() + 1.0), value: value.ln_1p() }
    }
    fn exp(self) -> Self {
        let value = self.value.clone().exp();
        self.chain(value.clone(), value)
    }
    fn exp_m1(self) -> Self {
        let (value, slope) = (self.value.clone().exp_m1(), self.value.clone().exp());
        self.chain(value, slope)
    }
    fn tanh(self) -> Self {
        let value = self.value.clone().tanh();
        let slope = -(value.clone().squared()) + 1.0;
        self.chain(value, slope)
    }
    fn select_below(&self, threshold: f64, below: Self, otherwise: Self) -> Self {
        Self {
            value: self.value.select_below(threshold, below.value, otherwise.value),
            derivative: self.value.select_below(threshold, below.derivative, otherwise.derivative),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_operation_agrees_with_central_differences() {
        // A formula that uses every operation of the trait.
        fn formula<S: Scalar>(x: S) -> S {
            let quotient = (x.clone() * 3.0 + 2.0).ln() / (x.clone().exp() + 1.0);
            let rest = (x.clone() - 0.3).tanh() * (x.clone() * 0.1).ln_1p() - (-x.clone()).exp_m1();
            let chosen = x.select_below(0.5, x.clone() * 2.0, x.clone().squared());
            quotient + rest * x.constant(1.5) + chosen - x * 0.25
        }
        const STEP: f64 = 3e-6; // balances rounding and truncation of a central difference
        for x in [-0.4, 0.2, 0.9, 1.7] {
            let dual = formula(Dual { value: x, derivative: 1.0 });
            let difference = (formula(x + STEP) - formula(x - STEP)) / (2.0 * STEP);
            assert_eq!(dual.value, formula(x));
            assert!((dual.derivative - difference).abs() < 1e-9, "{x}");
        }
    }
}
