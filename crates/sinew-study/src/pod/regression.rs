//! Regression of mode coefficients: ridge polynomials and a Gaussian process, chosen by leave-one-out.

use std::fmt;

use nalgebra::{Cholesky, DMatrix, RowDVector};

/// The regression that predicts the coefficients, for reports.
#[derive(Clone, Debug, PartialEq)]
pub enum Regression {
    /// Polynomial of a total degree, fitted with a ridge penalty.
    Polynomial {
        /// Total degree.
        degree: usize,
        /// Penalty per sample on the squares of all coefficients but the constant.
        ridge: f64,
    },
    /// Gaussian process with the kernel `exp(−½ Σ_d (x_d − x'_d)²/ℓ_d²)`.
    GaussianProcess {
        /// ℓ, one per parameter, in standard deviations of its logarithm.
        lengths: Vec<f64>,
        /// Variance of the noise relative to that of the signal.
        nugget: f64,
    },
}

impl fmt::Display for Regression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Polynomial { degree, ridge } => {
                write!(f, "polynomial of degree {degree}, ridge {ridge:.0e}")
            }
            Self::GaussianProcess { lengths, nugget } => {
                write!(f, "Gaussian process, lengths {lengths:.2?}, nugget {nugget:.0e}")
            }
        }
    }
}

/// A regression with what it needs to predict; one column of weights per mode.
#[derive(Clone, Debug)]
pub(super) struct Fitted {
    pub(super) regression: Regression,
    pub(super) basis: Basis,
    pub(super) weights: DMatrix<f64>,
    /// Sum over the samples of the squared error of the field.
    pub(super) leave_one_out: f64,
}

/// The functions of `x` that the weights belong to.
#[derive(Clone, Debug)]
pub(super) enum Basis {
    /// One row of exponents per monomial.
    Monomials(Vec<Vec<i32>>),
    /// Kernels with these lengths at the training points, one per row.
    Kernels { lengths: Vec<f64>, points: DMatrix<f64> },
}

impl Basis {
    /// The functions at one point.
    pub(super) fn at(&self, x: &RowDVector<f64>) -> RowDVector<f64> {
        match self {
            Self::Monomials(exponents) => RowDVector::from_iterator(
                exponents.len(),
                exponents.iter().map(|e| x.iter().zip(e).map(|(x, &e)| x.powi(e)).product()),
            ),
            Self::Kernels { lengths, points } => RowDVector::from_iterator(
                points.nrows(),
                points.row_iter().map(|point| {
                    let scaled = (0..lengths.len()).map(|d| (x[d] - point[d]) / lengths[d]);
                    (-0.5 * scaled.map(|s| s * s).sum::<f64>()).exp()
                }),
            ),
        }
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
        // With as many coefficients as samples, leaving one out leaves nothing to learn from.
        let Some(exponents) = monomials(points.ncols(), degree, points.nrows() - 1) else { break };
        let basis = Basis::Monomials(exponents);
        let values = basis.at_all(points);
        for exponent in -14..=0 {
            let ridge = 10f64.powi(exponent);
            let Some((weights, leave_one_out)) = solve_ridge(&values, targets, ridge) else {
                continue;
            };
            if leave_one_out < best.leave_one_out {
                let regression = Regression::Polynomial { degree, ridge };
                best = Fitted { regression, basis: basis.clone(), weights, leave_one_out };
            }
        }
    }
    best
}

/// The polynomial of degree 0; the targets have mean zero, so it is zero.
fn constant(targets: &DMatrix<f64>) -> Fitted {
    let samples = targets.nrows() as f64;
    Fitted {
        regression: Regression::Polynomial { degree: 0, ridge: 0.0 },
        basis: Basis::Monomials(vec![Vec::new()]),
        weights: DMatrix::zeros(1, targets.ncols()),
        leave_one_out: targets.norm_squared() * (samples / (samples - 1.0)).powi(2),
    }
}

/// Exponents of all monomials up to a total degree, the constant first; none if more than `most`.
pub(super) fn monomials(variables: usize, degree: usize, most: usize) -> Option<Vec<Vec<i32>>> {
    let mut exponents = vec![vec![0; variables]];
    let mut start = 0;
    for _ in 0..degree {
        let end = exponents.len();
        for at in start..end {
            // Raising only from the last variable used on makes each monomial once.
            let last = exponents[at].iter().rposition(|&e| e > 0).unwrap_or(0);
            for variable in last..variables {
                let mut next = exponents[at].clone();
                next[variable] += 1;
                exponents.push(next);
            }
            if exponents.len() > most {
                return None;
            }
        }
        start = end;
    }
    Some(exponents)
}

/// Weights of least squares with a penalty on all but the first function, and the
/// leave-one-out sum of squares: residuals over one minus the leverage (Allen, 1974).
pub(super) fn solve_ridge(
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

/// Bounds and start of the logarithms of the lengths: points have standard deviation 1.
const LOG_LENGTH: (f64, f64, f64) = (-3.0, 0.7, 4.6);
/// Bounds and start of the logarithm of the nugget: 1e-13 still factorises, 1 fits nothing.
const LOG_NUGGET: (f64, f64, f64) = (-30.0, -18.0, 0.0);

/// Lengths and nugget of least leave-one-out error, by a pattern search over their logarithms.
pub(super) fn fit_process(points: &DMatrix<f64>, targets: &DMatrix<f64>) -> Option<Fitted> {
    let variables = points.ncols();
    let bounds = |d: usize| if d < variables { LOG_LENGTH } else { LOG_NUGGET };
    let mut at: Vec<f64> = (0..=variables).map(|d| bounds(d).1).collect();
    let mut best = solve_process(points, targets, &at)?;
    // Steps of e² down to e^⅛: finer ones change the error by a few percent only.
    let mut step = 2.0;
    while step >= 0.125 {
        let before = best.leave_one_out;
        for d in 0..=variables {
            for direction in [step, -step] {
                let mut trial = at.clone();
                trial[d] = (at[d] + direction).clamp(bounds(d).0, bounds(d).2);
                match solve_process(points, targets, &trial) {
                    Some(fit) if fit.leave_one_out < best.leave_one_out => {
                        (at, best) = (trial, fit)
                    }
                    _ => {}
                }
            }
        }
        // A sweep that gains less than a percent is not worth another at this step.
        if best.leave_one_out >= 0.99 * before {
            step /= 2.0;
        }
    }
    Some(best)
}

/// A Gaussian process with given hyperparameters, and its leave-one-out sum of squares
/// (Rasmussen & Williams, "Gaussian Processes for Machine Learning", 2006, Eq. 5.12).
pub(super) fn solve_process(
    points: &DMatrix<f64>,
    targets: &DMatrix<f64>,
    logarithms: &[f64],
) -> Option<Fitted> {
    let (log_nugget, log_lengths) = logarithms.split_last()?;
    let lengths: Vec<f64> = log_lengths.iter().map(|l| l.exp()).collect();
    let nugget = log_nugget.exp();
    let basis = Basis::Kernels { lengths: lengths.clone(), points: points.clone() };
    let mut covariance = basis.at_all(points);
    for i in 0..covariance.nrows() {
        covariance[(i, i)] += nugget;
    }
    let factor = Cholesky::new(covariance)?;
    let (weights, inverse) = (factor.solve(targets), factor.inverse());
    let squares =
        weights.row_iter().enumerate().map(|(i, w)| w.norm_squared() / inverse[(i, i)].powi(2));
    let leave_one_out = squares.sum::<f64>();
    let regression = Regression::GaussianProcess { lengths, nugget };
    leave_one_out.is_finite().then_some(Fitted { regression, basis, weights, leave_one_out })
}
