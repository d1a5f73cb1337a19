//! What every kernel must satisfy, for those of this crate and of its users.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_num::Series;
use thiserror::Error;

use super::{Kernel, Orders, Pairs, table};

/// A property that a kernel lacks.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum KernelFault {
    /// The number of values does not match [`Kernel::hyperparameters`].
    #[error("{found} hyperparameter values for a kernel that names {expected}")]
    Hyperparameters {
        /// Values given.
        found: usize,
        /// Names declared.
        expected: usize,
    },
    /// k(x, x′) ≠ k(x′, x).
    #[error("not symmetric: k(x, x') = {forward}, k(x', x) = {backward}")]
    Symmetry {
        /// k(x, x′).
        forward: f64,
        /// k(x′, x).
        backward: f64,
    },
    /// A covariance matrix with a negative eigenvalue.
    #[error("the covariance of {points} points has the pivot {pivot:e} in units of the variance")]
    Definiteness {
        /// Number of points.
        points: usize,
        /// First negative pivot of its factorisation.
        pivot: f64,
    },
    /// Derivatives that do not belong to the formula.
    #[error("derivative {orders}: {given} in the table, {expected} by {method}")]
    Derivative {
        /// Which derivative, in words.
        orders: String,
        /// In the kernel's table.
        given: f64,
        /// As it should be.
        expected: f64,
        /// How that was found.
        method: &'static str,
    },
    /// A gradient that does not belong to the table.
    #[error("gradient in hyperparameter {number}: {given}, by differences {expected}")]
    Gradient {
        /// Which hyperparameter.
        number: usize,
        /// As given.
        given: f64,
        /// As it should be.
        expected: f64,
    },
}

/// Checks symmetry, positive definiteness, the table of derivatives against Taylor series of the
/// formula and against finite differences, and the gradient in the hyperparameters against
/// differences of the table, on random points between `lower` and `upper`.
///
/// Derivatives are taken up to order two in either argument, as far as the kernel is smooth.
///
/// # Errors
/// The first fault found.
pub fn check_kernel<const D: usize>(
    kernel: &dyn Kernel<D>,
    hyperparameters: &[f64],
    lower: [f64; D],
    upper: [f64; D],
    seed: u64,
) -> Result<(), KernelFault> {
    let expected = kernel.hyperparameters().len();
    if hyperparameters.len() != expected {
        return Err(KernelFault::Hyperparameters { found: hyperparameters.len(), expected });
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || std::array::from_fn(|d| random.random_range(lower[d]..upper[d]));
    let points: Vec<[f64; D]> = (0..12).map(|_| draw()).collect();
    let checked = Checked { kernel, hyperparameters, points: &points };
    checked.symmetry()?;
    checked.definiteness()?;
    checked.derivatives()?;
    checked.gradient()
}

struct Checked<'a, const D: usize> {
    kernel: &'a dyn Kernel<D>,
    hyperparameters: &'a [f64],
    points: &'a [[f64; D]],
}

/// Between closed forms and Taylor series, relative to the largest entry.
const TAYLOR_TOLERANCE: f64 = 1e-11;
/// Between analytic derivatives and central differences of step 1e-5.
const DIFFERENCE_TOLERANCE: f64 = 1e-6;
const STEP: f64 = 1e-5;

fn close(a: f64, b: f64, scale: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * scale.max(1.0)
}

impl<const D: usize> Checked<'_, D> {
    fn value(&self, x: [f64; D], y: [f64; D]) -> f64 {
        let hyperparameters: Vec<Series> =
            self.hyperparameters.iter().map(|h| Series::plain([*h])[0].clone()).collect();
        self.kernel.formula(&hyperparameters, &Series::plain(x), &Series::plain(y)).value()
    }

    fn symmetry(&self) -> Result<(), KernelFault> {
        for pair in self.points.windows(2) {
            let (forward, backward) = (self.value(pair[0], pair[1]), self.value(pair[1], pair[0]));
            if !close(forward, backward, forward.abs(), TAYLOR_TOLERANCE) {
                return Err(KernelFault::Symmetry { forward, backward });
            }
        }
        Ok(())
    }

    /// By Cholesky's algorithm with room for rounding.
    fn definiteness(&self) -> Result<(), KernelFault> {
        let n = self.points.len();
        let mut a: Vec<Vec<f64>> = self
            .points
            .iter()
            .map(|x| self.points.iter().map(|y| self.value(*x, *y)).collect())
            .collect();
        let scale = (0..n).map(|i| a[i][i]).fold(f64::MIN_POSITIVE, f64::max);
        for k in 0..n {
            let pivot = a[k][k] / scale;
            if pivot.is_nan() || pivot < -TAYLOR_TOLERANCE {
                return Err(KernelFault::Definiteness { points: n, pivot });
            }
            // A pivot of rounding size belongs to a point that the others determine.
            if pivot <= TAYLOR_TOLERANCE {
                continue;
            }
            for i in k + 1..n {
                let factor = a[i][k] / a[k][k];
                for j in k + 1..n {
                    a[i][j] -= factor * a[k][j];
                }
            }
        }
        Ok(())
    }

    /// All orders up to two in each argument, one axis at a time and mixed.
    fn orders(&self) -> Vec<Orders<D>> {
        let most = self.kernel.smoothness().unwrap_or(2).min(2);
        let mut orders = vec![Orders { first: [0; D], second: [0; D] }];
        for d in 0..D {
            for (m, n) in [(1, 0), (0, 1), (1, 1), (2, 0), (2, 1), (0, 2), (2, 2)] {
                if m <= most && n <= most {
                    let mut order = Orders { first: [0; D], second: [0; D] };
                    order.first[d] = m;
                    order.second[(d + 1) % D] = n;
                    orders.push(order);
                }
            }
        }
        if self.kernel.is_stationary() {
            for order in &mut orders {
                *order = Orders { first: order.sums(), second: [0; D] };
            }
        }
        orders
    }

    fn table(&self, hyperparameters: &[f64], second: [f64; D], orders: &[Orders<D>]) -> Vec<f64> {
        let axes: [Vec<f64>; D] =
            std::array::from_fn(|d| self.points.iter().map(|p| p[d]).collect());
        let pairs = Pairs { first: axes.each_ref().map(Vec::as_slice), second };
        let mut table = vec![0.0; orders.len() * pairs.count()];
        self.kernel.derivatives(hyperparameters, &pairs, orders, &mut table);
        table
    }

    fn derivatives(&self) -> Result<(), KernelFault> {
        let orders = self.orders();
        let n = self.points.len();
        // Off the points themselves, where rough kernels have no Taylor series.
        let second = std::array::from_fn(|d| 0.5 * (self.points[0][d] + self.points[1][d]));
        let table = self.table(self.hyperparameters, second, &orders);
        let axes: [Vec<f64>; D] =
            std::array::from_fn(|d| self.points.iter().map(|p| p[d]).collect());
        let pairs = Pairs { first: axes.each_ref().map(Vec::as_slice), second };
        let mut series = vec![0.0; table.len()];
        table::by_series(self.kernel, self.hyperparameters, &pairs, &orders, &mut series);
        for (entry, order) in orders.iter().enumerate() {
            let rows = entry * n..(entry + 1) * n;
            let scale = series[rows.clone()].iter().fold(0.0_f64, |m, s| m.max(s.abs()));
            for (given, expected) in table[rows.clone()].iter().zip(&series[rows]) {
                if !close(*given, *expected, scale, TAYLOR_TOLERANCE) {
                    return Err(fault(order, *given, *expected, "Taylor series"));
                }
            }
        }
        self.differences(second)
    }

    /// First derivatives in either argument against differences of the formula.
    fn differences(&self, second: [f64; D]) -> Result<(), KernelFault> {
        for d in 0..D {
            let mut first_order = Orders { first: [0; D], second: [0; D] };
            first_order.first[d] = 1;
            let table = self.table(self.hyperparameters, second, &[first_order]);
            for (point, given) in self.points.iter().zip(&table) {
                let at = |step: f64| {
                    let mut moved = *point;
                    moved[d] += step;
                    self.value(moved, second)
                };
                let expected = (at(STEP) - at(-STEP)) / (2.0 * STEP);
                if !close(*given, expected, expected.abs(), DIFFERENCE_TOLERANCE) {
                    return Err(fault(&first_order, *given, expected, "central differences"));
                }
            }
        }
        Ok(())
    }

    fn gradient(&self) -> Result<(), KernelFault> {
        let orders = self.orders();
        // One of the points is the second one: what happens on the diagonal counts too.
        let second = self.points[0];
        let n = self.points.len();
        let weights: Vec<f64> =
            (0..orders.len() * n).map(|k| ((k * 7 + 3) % 11) as f64 / 11.0 - 0.4).collect();
        let axes: [Vec<f64>; D] =
            std::array::from_fn(|d| self.points.iter().map(|p| p[d]).collect());
        let pairs = Pairs { first: axes.each_ref().map(Vec::as_slice), second };
        let mut gradient = vec![0.0; self.hyperparameters.len()];
        self.kernel.pull_back(self.hyperparameters, &pairs, &orders, &weights, &mut gradient);
        let sum = |number: usize, step: f64| -> f64 {
            let mut moved = self.hyperparameters.to_vec();
            moved[number] *= step.exp();
            self.table(&moved, second, &orders).iter().zip(&weights).map(|(t, w)| t * w).sum()
        };
        for (number, given) in gradient.iter().enumerate() {
            let expected = (sum(number, STEP) - sum(number, -STEP)) / (2.0 * STEP);
            let scale = expected.abs().max(sum(number, 0.0).abs());
            if !close(*given, expected, scale, DIFFERENCE_TOLERANCE) {
                return Err(KernelFault::Gradient { number, given: *given, expected });
            }
        }
        Ok(())
    }
}

fn fault<const D: usize>(
    orders: &Orders<D>,
    given: f64,
    expected: f64,
    method: &'static str,
) -> KernelFault {
    let orders = format!("{:?} in x, {:?} in x'", orders.first, orders.second);
    KernelFault::Derivative { orders, given, expected, method }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{
        Along, Linear, Matern, Measure, Periodic, Product, RationalQuadratic, Scaled, Smoothness,
        SquaredExponential, Sum,
    };

    #[test]
    fn all_kernels_conform() {
        let kernels: Vec<Box<dyn Kernel<2>>> = vec![
            Box::new(SquaredExponential::new()),
            Box::new(SquaredExponential::along(&[1])),
            Box::new(RationalQuadratic::new()),
            Box::new(Matern::new(Smoothness::Once)),
            Box::new(Matern::new(Smoothness::Twice)),
            Box::new(Matern::new(Smoothness::Thrice)),
            Box::new(Linear::new()),
            Box::new(Periodic::new(0, 1.3)),
            Box::new(Product::new(SquaredExponential::along(&[1]), Periodic::new(0, 1.3))),
            Box::new(Product::new(Linear::new(), SquaredExponential::new())),
            Box::new(Sum::new(
                Scaled::new(SquaredExponential::new()),
                Scaled::new(RationalQuadratic::new()),
            )),
            Box::new(Sum::new(Linear::new(), Periodic::new(1, 0.9))),
            Box::new(Along::new(&SquaredExponential::new(), [0.6, 0.8], &[0, 1])),
            Box::new(Along::new(&Linear::new(), [0.6, -0.8], &[0, 1])),
        ];
        for kernel in &kernels {
            let values: Vec<f64> = kernel
                .hyperparameters()
                .iter()
                .enumerate()
                .map(|(number, h)| match h.measure {
                    Measure::Length { .. } => 0.6 + 0.2 * number as f64,
                    Measure::Number { .. } => 1.1 + 0.1 * number as f64,
                })
                .collect();
            let result = check_kernel(&**kernel, &values, [-0.5, 0.0], [1.0, 2.0], 3);
            assert_eq!(result, Ok(()), "{}", kernel.name());
        }
    }

    /// k(x, x′) = x − 2x′ in the first axis.
    #[derive(Debug)]
    struct Skew;

    impl Kernel<1> for Skew {
        fn name(&self) -> String {
            "skew".into()
        }
        fn hyperparameters(&self) -> Vec<crate::kernel::Hyperparameter> {
            Vec::new()
        }
        fn on_axes(&self, _: &[usize]) -> Box<dyn Kernel<1>> {
            Box::new(Skew)
        }
        fn formula(&self, _: &[Series], x: &[Series; 1], y: &[Series; 1]) -> Series {
            &x[0] - &y[0] * 2.0
        }
    }

    #[test]
    fn faults_are_found() {
        let fault = check_kernel(&Skew, &[], [0.0], [1.0], 1).unwrap_err();
        assert!(matches!(fault, KernelFault::Symmetry { .. }), "{fault}");
        let count = check_kernel(&Skew, &[1.0], [0.0], [1.0], 1).unwrap_err();
        assert_eq!(count, KernelFault::Hyperparameters { found: 1, expected: 0 });
    }
}
