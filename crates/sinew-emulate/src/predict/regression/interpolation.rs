//! Interpolation of mode coefficients, and polynomials with a ridge penalty for it.

use super::process::{Conditional, logarithms};
use nalgebra::{Cholesky, DMatrix, RowDVector};
use serde::{Deserialize, Serialize};
use sinew_num::monomials;
use std::fmt;

/// Interpolation of the coefficients, for reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// Polynomial of a total degree, fitted with a ridge penalty.
    Polynomial {
        /// Total degree.
        degree: usize,
        /// Penalty per sample on the squares of all coefficients but the constant.
        ridge: f64,
    },
    /// Gaussian process with the kernel `exp(−½ Σ_d (x_d − x'_d)²/ℓ_d²)` about a polynomial.
    GaussianProcess {
        /// Total degree of the polynomial.
        trend: usize,
        /// ℓ, one per parameter, in standard deviations of its range.
        lengths: Vec<f64>,
        /// Variance of the noise relative to that of the signal.
        nugget: f64,
    },
}

impl fmt::Display for Interpolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Polynomial { degree, ridge } => {
                write!(f, "polynomial of degree {degree}, ridge {ridge:.0e}")
            }
            Self::GaussianProcess { trend, lengths, nugget } => {
                let lengths: Vec<_> = lengths.iter().map(|l| format!("{l:.2}")).collect();
                let lengths = lengths.join(", ");
                write!(
                    f,
                    "Gaussian process about a polynomial of degree {trend}, lengths {lengths}, nugget {nugget:.0e}"
                )
            }
        }
    }
}

/// An interpolation with what it needs to predict; one column of weights per mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Fitted {
    pub(super) interpolation: Interpolation,
    pub(super) basis: Basis,
    #[serde(with = "super::matrix")]
    pub(super) weights: DMatrix<f64>,
    /// Sum over the samples of the squared error of the field.
    pub(super) leave_one_out: f64,
}

impl Fitted {
    /// Covariance of points with the hyperparameters of the process; `None` of a polynomial.
    pub(super) fn conditional(&self, points: &DMatrix<f64>) -> Option<Conditional> {
        let Interpolation::GaussianProcess { trend, lengths, nugget } = &self.interpolation else {
            return None;
        };
        let exponents = monomials(points.ncols(), *trend);
        Conditional::new(points, &exponents, &logarithms(lengths, *nugget))
    }

    /// Interpolation with these hyperparameters at other points.
    pub(super) fn refitted(&self, points: &DMatrix<f64>, targets: &DMatrix<f64>) -> Option<Self> {
        match &self.interpolation {
            Interpolation::Polynomial { ridge, .. } => {
                let basis = Basis::monomials(self.basis.exponents.clone());
                let (weights, leave_one_out) = solve_ridge(&basis.at_all(points), targets, *ridge)?;
                let interpolation = self.interpolation.clone();
                Some(Self { interpolation, basis, weights, leave_one_out })
            }
            Interpolation::GaussianProcess { trend, .. } => {
                self.conditional(points)?.fitted(*trend, targets)
            }
        }
    }

    /// Root mean square of the leave-one-out error relative to fields of such a sum of squares.
    pub(super) fn relative_error(&self, size: f64) -> f64 {
        if size > 0.0 { (self.leave_one_out / size).sqrt() } else { 0.0 }
    }

    /// The coefficients at one point.
    pub(super) fn at(&self, x: &RowDVector<f64>) -> RowDVector<f64> {
        self.basis.at(x) * &self.weights
    }
}

/// The functions of `x` that the weights belong to: for each set of lengths, one after the other, kernels at these points, one per row; then
/// monomials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Basis {
    pub(super) lengths: Vec<f64>,
    #[serde(with = "super::matrix")]
    pub(super) points: DMatrix<f64>,
    /// One row of exponents per monomial.
    pub(super) exponents: Vec<Vec<i32>>,
}

impl Basis {
    pub(super) fn monomials(exponents: Vec<Vec<i32>>) -> Self {
        Self { lengths: Vec::new(), points: DMatrix::zeros(0, 0), exponents }
    }

    /// The functions at one point.
    pub(super) fn at(&self, x: &RowDVector<f64>) -> RowDVector<f64> {
        // Loops: nested adapters of iterators are not inlined.
        let mut values = Vec::new();
        for lengths in self.lengths.chunks(x.len().max(1)) {
            for point in self.points.row_iter() {
                let scaled = (0..lengths.len()).map(|d| (x[d] - point[d]) / lengths[d]);
                values.push((-0.5 * scaled.map(|s| s * s).sum::<f64>()).exp());
            }
        }
        let monomial = |e: &Vec<i32>| x.iter().zip(e).map(|(x, &e)| x.powi(e)).product::<f64>();
        values.extend(self.exponents.iter().map(monomial));
        RowDVector::from_vec(values)
    }

    /// Derivatives of the functions at one point, where they have these values; a column per coordinate.
    pub(super) fn slopes(&self, x: &RowDVector<f64>, values: &RowDVector<f64>) -> DMatrix<f64> {
        let samples = self.points.nrows();
        DMatrix::from_fn(values.len(), x.len(), |function, d| {
            let Some(monomial) = function.checked_sub(values.len() - self.exponents.len()) else {
                let distance = x[d] - self.points[(function % samples, d)];
                return -values[function] * distance
                    / self.lengths[function / samples * x.len() + d].powi(2);
            };
            let exponents = &self.exponents[monomial];
            let power = |k: usize| exponents[k] - i32::from(k == d && exponents[k] > 0);
            let factor = f64::from(exponents[d]);
            factor * (0..x.len()).map(|k| x[k].powi(power(k))).product::<f64>()
        })
    }

    /// One row per point.
    pub(super) fn at_all(&self, points: &DMatrix<f64>) -> DMatrix<f64> {
        let rows: Vec<_> = points.row_iter().map(|x| self.at(&x.into_owned())).collect();
        DMatrix::from_rows(&rows)
    }
}

/// The degree and ridge of least leave-one-out error.
pub(super) fn fit_polynomial(
    points: &DMatrix<f64>,
    targets: &DMatrix<f64>,
    degree: usize,
) -> Fitted {
    let mut best = constant(targets);
    for degree in 1..=degree {
        let exponents = monomials(points.ncols(), degree);
        // With as many coefficients as samples, leaving one out leaves nothing to learn from.
        if exponents.len() >= points.nrows() {
            break;
        }
        let basis = Basis::monomials(exponents);
        let values = basis.at_all(points);
        for exponent in -14..=0 {
            let ridge = 10f64.powi(exponent);
            let solved = solve_ridge(&values, targets, ridge);
            let Some((weights, leave_one_out)) = solved else { continue };
            if leave_one_out < best.leave_one_out {
                let interpolation = Interpolation::Polynomial { degree, ridge };
                best = Fitted { interpolation, basis: basis.clone(), weights, leave_one_out };
            }
        }
    }
    best
}

/// The polynomial of degree 0; the targets have mean zero, so it is zero.
fn constant(targets: &DMatrix<f64>) -> Fitted {
    let samples = targets.nrows() as f64;
    Fitted {
        interpolation: Interpolation::Polynomial { degree: 0, ridge: 0.0 },
        basis: Basis::monomials(vec![Vec::new()]),
        weights: DMatrix::zeros(1, targets.ncols()),
        leave_one_out: targets.norm_squared() * (samples / (samples - 1.0)).powi(2),
    }
}

/// Weights of least squares with a penalty on all but the first function, and the
/// leave-one-out sum of squares: residuals over one minus the leverage (Allen, 1974).
fn solve_ridge(
    values: &DMatrix<f64>,
    targets: &DMatrix<f64>,
    ridge: f64,
) -> Option<(DMatrix<f64>, f64)> {
    let mut normal = values.tr_mul(values);
    for i in 1..normal.nrows() {
        normal[(i, i)] += ridge * values.nrows() as f64;
    }
    let factor = Cholesky::new(normal)?;
    let weights = factor.solve(&values.tr_mul(targets));
    let smoother = factor.solve(&values.transpose());
    let residuals = targets - values * &weights;
    let squares = residuals.row_iter().enumerate().map(|(i, residual)| {
        let leverage = values.row(i).transpose().dot(&smoother.column(i));
        residual.norm_squared() / (1.0 - leverage).powi(2)
    });
    let leave_one_out = squares.sum::<f64>();
    leave_one_out.is_finite().then_some((weights, leave_one_out))
}
