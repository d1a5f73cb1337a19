//! Regression of observables on logarithms of parameters: polynomials through values and derivatives at design points.

use nalgebra::{Cholesky, DMatrix, DVector};
use sinew_num::monomials;

/// Ridge penalties that are tried, per equation.
const RIDGES: [f64; 4] = [1e-14, 1e-11, 1e-8, 1e-5];
/// Smallest number of equations per coefficient, so that the leave-one-out error is meaningful.
const EQUATIONS_PER_COEFFICIENT: f64 = 1.5;

/// Observables with derivatives at one point.
pub(crate) struct Sample {
    /// Standardised logarithms of the parameters.
    pub x: Vec<f64>,
    /// Observables in standard deviations of their data.
    pub values: Vec<f64>,
    /// Derivatives in `x`, one row per observable; empty if there are none.
    pub slopes: Vec<Vec<f64>>,
    /// Weight of its equations, from the posterior density there.
    pub weight: f64,
}

/// Polynomials of one total degree, one per observable.
pub(crate) struct Polynomial {
    exponents: Vec<Vec<i32>>,
    /// One row per monomial, one column per observable.
    coefficients: DMatrix<f64>,
    /// Covariance of the leave-one-out errors of the observables: weighted mean of squares and products.
    pub leave_one_out: DMatrix<f64>,
    /// Total degree.
    pub degree: usize,
}

impl Polynomial {
    /// The degree and ridge of least leave-one-out error; `lengths` are the distances in `x` over which derivatives matter. None
    /// if there are too few samples for a constant.
    pub(crate) fn fit(samples: &[Sample], lengths: &[f64], highest: usize) -> Option<Self> {
        let mut best: Option<Self> = None;
        let equations: usize = samples.iter().map(|s| rows_of(s, lengths.len())).sum();
        for degree in 0..=highest {
            let exponents = monomials(lengths.len(), degree);
            if exponents.len() as f64 * EQUATIONS_PER_COEFFICIENT > equations as f64 {
                break;
            }
            let system = System::new(samples, lengths, &exponents);
            for ridge in RIDGES {
                let Some((coefficients, leave_one_out)) = system.solve(ridge) else { continue };
                let error = leave_one_out.trace();
                let better = |best: &Self| error < best.leave_one_out.trace();
                if error.is_finite() && best.as_ref().is_none_or(better) {
                    let exponents = exponents.clone();
                    best = Some(Self { exponents, coefficients, leave_one_out, degree });
                }
            }
        }
        best
    }

    /// Values of all observables at `x`, with derivatives in `x`, one row per observable.
    pub(crate) fn at(&self, x: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let powers = powers(x, self.degree);
        let count = self.exponents.len();
        let phi = DVector::from_iterator(count, self.exponents.iter().map(|e| value(&powers, e)));
        let slopes =
            DMatrix::from_fn(count, x.len(), |row, at| slope(&powers, &self.exponents[row], at));
        (self.coefficients.tr_mul(&phi), self.coefficients.tr_mul(&slopes))
    }
}

/// Equations of a sample.
fn rows_of(sample: &Sample, parameters: usize) -> usize {
    if sample.slopes.is_empty() { 1 } else { 1 + parameters }
}

/// Weighted equations of all samples.
struct System {
    matrix: DMatrix<f64>,
    targets: DMatrix<f64>,
    /// Rows of each sample, and its weight.
    blocks: Vec<(usize, usize, f64)>,
}

impl System {
    fn new(samples: &[Sample], lengths: &[f64], exponents: &[Vec<i32>]) -> Self {
        let observables = samples[0].values.len();
        let (mut rows, mut targets, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
        for sample in samples {
            let root = sample.weight.sqrt();
            blocks.push((rows.len(), rows_of(sample, lengths.len()), sample.weight));
            targets.push(sample.values.iter().map(|v| root * v).collect::<Vec<_>>());
            let slopes = if sample.slopes.is_empty() { &[] } else { lengths };
            let scaled = |row: Vec<f64>| row.into_iter().map(|x| root * x).collect::<Vec<_>>();
            rows.extend(equations(&sample.x, slopes, exponents).into_iter().map(scaled));
            for (at, length) in slopes.iter().enumerate() {
                targets.push(sample.slopes.iter().map(|row| root * length * row[at]).collect());
            }
        }
        let matrix = DMatrix::from_fn(rows.len(), exponents.len(), |i, j| rows[i][j]);
        let targets = DMatrix::from_fn(rows.len(), observables, |i, j| targets[i][j]);
        Self { matrix, targets, blocks }
    }

    /// Coefficients, and the covariance of the errors of values at samples that are left out with all their equations.
    fn solve(&self, ridge: f64) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let weight: f64 = self.blocks.iter().map(|block| block.2).sum();
        let mut normal = self.matrix.tr_mul(&self.matrix);
        for at in 1..normal.nrows() {
            normal[(at, at)] += ridge * self.matrix.nrows() as f64;
        }
        let factor = Cholesky::new(normal)?;
        let coefficients = factor.solve(&self.matrix.tr_mul(&self.targets));
        let residuals = &self.targets - &self.matrix * &coefficients;
        let count = self.targets.ncols();
        let mut covariance = DMatrix::zeros(count, count);
        for &(start, rows, _) in &self.blocks {
            let own = self.matrix.rows(start, rows);
            let leverage = own * factor.solve(&own.transpose());
            let left = DMatrix::identity(rows, rows) - leverage;
            let out = left.lu().solve(&residuals.rows(start, rows).into_owned())?;
            // The first equation is that of the values, times the root of the weight.
            covariance += out.row(0).tr_mul(&out.row(0));
        }
        Some((coefficients, covariance / weight))
    }
}

/// Values of all monomials at a point, then their derivatives along each of its variables times a length.
pub(crate) fn equations(x: &[f64], lengths: &[f64], exponents: &[Vec<i32>]) -> Vec<Vec<f64>> {
    let degree = exponents.iter().flatten().copied().max().unwrap_or(0) as usize;
    let powers = powers(x, degree);
    let slopes = |(at, length): (usize, &f64)| {
        exponents.iter().map(|e| length * slope(&powers, e, at)).collect()
    };
    let values = exponents.iter().map(|e| value(&powers, e)).collect();
    std::iter::once(values).chain(lengths.iter().enumerate().map(slopes)).collect()
}

/// `powers[d][n]` is x_d to the n.
fn powers(x: &[f64], degree: usize) -> Vec<Vec<f64>> {
    let of = |x: &f64| {
        std::iter::successors(Some(1.0), |power| Some(power * x)).take(degree + 1).collect()
    };
    x.iter().map(of).collect()
}

fn value(powers: &[Vec<f64>], exponents: &[i32]) -> f64 {
    powers.iter().zip(exponents).map(|(p, &e)| p[e as usize]).product()
}

fn slope(powers: &[Vec<f64>], exponents: &[i32], at: usize) -> f64 {
    if exponents[at] == 0 {
        return 0.0;
    }
    let factor = |(d, (p, &e)): (usize, (&Vec<f64>, &i32))| match d == at {
        true => f64::from(e) * p[e as usize - 1],
        false => p[e as usize],
    };
    powers.iter().zip(exponents).enumerate().map(factor).product()
}
