//! Second-order Taylor numbers: value, gradient and Hessian.

use crate::scalar::taylor_operators;
use std::ops::Mul;

/// A value with its gradient and Hessian in `N` variables: one evaluation of an energy in the
/// nine entries of ∇u gives stress and tangent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<const N: usize> {
    /// Value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; N],
    /// Second derivatives, symmetric.
    pub hessian: [[f64; N]; N],
}

impl<const N: usize> Jet<N> {
    /// A number that depends on no variable.
    pub fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; N], hessian: [[0.0; N]; N] }
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
    pub(crate) fn chain(mut self, f: f64, df: f64, ddf: f64) -> Self {
        let g = self.gradient;
        self.value = f;
        for i in 0..N {
            self.gradient[i] *= df;
            for j in 0..N {
                self.hessian[i][j] = df * self.hessian[i][j] + ddf * g[i] * g[j];
            }
        }
        self
    }

    fn zip(mut self, right: Self, op: impl Fn(f64, f64) -> f64) -> Self {
        self.value = op(self.value, right.value);
        for i in 0..N {
            self.gradient[i] = op(self.gradient[i], right.gradient[i]);
            for j in 0..N {
                self.hessian[i][j] = op(self.hessian[i][j], right.hessian[i][j]);
            }
        }
        self
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Self;
    fn mul(self, right: Self) -> Self {
        let mut result = Self::constant(self.value * right.value);
        for i in 0..N {
            result.gradient[i] = self.gradient[i] * right.value + self.value * right.gradient[i];
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

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Self;
    fn mul(mut self, right: f64) -> Self {
        self.value *= right;
        self.gradient.iter_mut().for_each(|g| *g *= right);
        self.hessian.as_flattened_mut().iter_mut().for_each(|h| *h *= right);
        self
    }
}

taylor_operators!(Jet);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Scalar, Slope};

    /// A formula that uses every operation of the trait.
    fn formula<S: Scalar>(x: S, y: S) -> S {
        let q = (x.clone() * y.clone() + 2.0).ln() / (y.clone().exp() + 1.0);
        let r =
            (x.clone() - y.clone()).tanh() * (x.clone() * 0.1).ln_1p() - (y.clone() * 0.3).exp_m1();
        let chosen = x.select_below(0.0, y.clone(), x.clone().squared());
        -q.at_least(-10.0) + r.at_most(10.0) * 2.0 + chosen
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        // Step of a central difference in f64 that balances rounding and truncation.
        const STEP: f64 = 1e-4;
        const TOLERANCE: f64 = 2e-7;
        for (x, y) in [(0.7, -0.4), (1.9, 0.3), (-0.2, 1.1)] {
            let jet = formula(Jet::<2>::variable(x, 0), Jet::variable(y, 1));
            let slope = formula(Slope::<2>::variable(x, 0), Slope::variable(y, 1));
            // Division goes through the reciprocal, so values agree to rounding only.
            assert!((jet.value - formula(x, y)).abs() < 1e-14);
            assert_eq!(slope.value, jet.value);
            let f = |dx: f64, dy: f64| formula(x + dx * STEP, y + dy * STEP);
            let difference = [
                (f(1.0, 0.0) - f(-1.0, 0.0)) / (2.0 * STEP),
                (f(0.0, 1.0) - f(0.0, -1.0)) / (2.0 * STEP),
            ];
            let second = [
                [
                    (f(1.0, 0.0) - 2.0 * f(0.0, 0.0) + f(-1.0, 0.0)) / (STEP * STEP),
                    (f(1.0, 1.0) - f(1.0, -1.0) - f(-1.0, 1.0) + f(-1.0, -1.0))
                        / (4.0 * STEP * STEP),
                ],
                [
                    jet.hessian[0][1],
                    (f(0.0, 1.0) - 2.0 * f(0.0, 0.0) + f(0.0, -1.0)) / (STEP * STEP),
                ],
            ];
            for i in 0..2 {
                assert!((jet.gradient[i] - difference[i]).abs() < TOLERANCE);
                assert!((slope.gradient[i] - jet.gradient[i]).abs() < 1e-14);
                for j in 0..2 {
                    assert!((jet.hessian[i][j] - second[i][j]).abs() < 1e-6, "{i}{j}");
                    assert_eq!(jet.hessian[i][j], jet.hessian[j][i]);
                }
            }
        }
    }

    #[test]
    fn logarithms_outside_their_domain_are_minus_infinity() {
        for x in [0.0, -1.0, -1e300] {
            assert_eq!(Scalar::ln(x), f64::NEG_INFINITY);
            assert_eq!(Scalar::ln_1p(x - 1.0), f64::NEG_INFINITY);
            assert_eq!(Scalar::ln(Jet::<1>::constant(x)).value, f64::NEG_INFINITY);
        }
    }

    #[test]
    fn branch_not_taken_does_not_leak() {
        let x = Slope::<1>::variable(2.0, 0);
        let infinite = Slope::<1>::variable(0.0, 0).ln();
        let kept = x.select_below(1.0, infinite, x * 3.0);
        assert_eq!((kept.value, kept.gradient[0]), (6.0, 3.0));
    }
}
