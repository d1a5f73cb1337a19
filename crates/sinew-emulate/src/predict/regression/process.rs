//! Gaussian processes about a polynomial, with one length per parameter.

use super::interpolation::{Basis, Fitted, Interpolation};
use nalgebra::{Cholesky, DMatrix};
use sinew_num::monomials;

/// Bounds and start of the logarithms of the lengths: points have standard deviation 1.
const LOG_LENGTH: (f64, f64, f64) = (-3.0, 0.7, 5.5);
/// Bounds and start of the logarithm of the nugget: 1e-13 still factorises, 1 fits nothing.
const LOG_NUGGET: (f64, f64, f64) = (-30.0, -18.0, 0.0);
/// Largest total degree of the trend.
const HIGHEST_TREND: usize = 2;

/// Trend, lengths and nugget of least leave-one-out error.
pub(super) fn fit_process(points: &DMatrix<f64>, targets: &DMatrix<f64>) -> Option<Fitted> {
    let fits = (0..=HIGHEST_TREND).filter_map(|trend| {
        // A trend of more than half as many coefficients as samples leaves little to the process.
        let exponents = monomials(points.ncols(), trend);
        let few = exponents.len() <= points.nrows() / 2;
        few.then(|| search(points, targets, trend, &exponents)).flatten()
    });
    fits.min_by(|a, b| a.leave_one_out.total_cmp(&b.leave_one_out))
}

/// Lengths and nugget of least leave-one-out error, by a pattern search over their logarithms.
fn search(
    points: &DMatrix<f64>,
    targets: &DMatrix<f64>,
    trend: usize,
    exponents: &[Vec<i32>],
) -> Option<Fitted> {
    let variables = points.ncols();
    let bounds = |d: usize| if d < variables { LOG_LENGTH } else { LOG_NUGGET };
    let mut at: Vec<f64> = (0..=variables).map(|d| bounds(d).1).collect();
    let solve = |at: &[f64]| solve_process(points, targets, trend, exponents, at);
    let mut best = solve(&at)?;
    // Steps of e² down to e^⅛: finer ones change the error by a few percent only.
    let mut step = 2.0;
    while step >= 0.125 {
        let before = best.leave_one_out;
        for d in 0..=variables {
            for direction in [step, -step] {
                let mut trial = at.clone();
                trial[d] = (at[d] + direction).clamp(bounds(d).0, bounds(d).2);
                match solve(&trial) {
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

/// A Gaussian process with given hyperparameters about a polynomial whose coefficients are unknown, and its
/// leave-one-out sum of squares (Dubrule, "Cross validation of kriging in a unique neighborhood", 1983).
pub(super) fn solve_process(
    points: &DMatrix<f64>,
    targets: &DMatrix<f64>,
    trend: usize,
    exponents: &[Vec<i32>],
    logarithms: &[f64],
) -> Option<Fitted> {
    let (log_nugget, log_lengths) = logarithms.split_last()?;
    let lengths: Vec<f64> = log_lengths.iter().map(|l| l.exp()).collect();
    let nugget = log_nugget.exp();
    let (samples, basis) = (
        points.nrows(),
        Basis { lengths: lengths.clone(), points: points.clone(), exponents: exponents.to_vec() },
    );
    let values = basis.at_all(points);
    let mut covariance = values.columns(0, samples).into_owned();
    (0..samples).for_each(|i| covariance[(i, i)] += nugget);
    let polynomial = values.columns(samples, exponents.len()).into_owned();
    let factor = Cholesky::new(covariance)?;
    let weighted = factor.solve(&polynomial);
    let schur = Cholesky::new(polynomial.tr_mul(&weighted))?;
    let coefficients = schur.solve(&weighted.tr_mul(targets));
    let kernels = factor.solve(&(targets - &polynomial * &coefficients));
    // The diagonal of the inverse of the covariance bordered by the polynomial.
    let (inverse, explained) = (factor.inverse(), schur.solve(&weighted.transpose()));
    let squares = kernels.row_iter().enumerate().map(|(i, row)| {
        let diagonal = inverse[(i, i)] - weighted.row(i).transpose().dot(&explained.column(i));
        row.norm_squared() / diagonal.powi(2)
    });
    let leave_one_out = squares.sum::<f64>();
    let mut weights = kernels.resize_vertically(samples + exponents.len(), 0.0);
    weights.rows_mut(samples, exponents.len()).copy_from(&coefficients);
    let interpolation = Interpolation::GaussianProcess { trend, lengths, nugget };
    leave_one_out.is_finite().then_some(Fitted { interpolation, basis, weights, leave_one_out })
}
