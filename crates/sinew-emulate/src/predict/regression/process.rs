//! Gaussian processes about a polynomial, with one length per parameter.

use super::design::{Groups, are_independent};
use super::interpolation::{Basis, Fitted, Interpolation};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, RowDVector};
use sinew_num::{monomials, try_in_parallel};

/// Bounds and start of the logarithms of the lengths: points have standard deviation 1.
const LOG_LENGTH: (f64, f64, f64) = (-3.0, 0.7, 5.5);
/// Bounds and start of the logarithm of the nugget: 1e-13 still factorises, 1 fits nothing.
const LOG_NUGGET: (f64, f64, f64) = (-30.0, -18.0, 0.0);
/// Largest total degree of the trend.
const HIGHEST_TREND: usize = 2;
/// First step of the search from the start: e².
const FIRST_STEP: f64 = 2.0;
/// Logarithm of the factor by which a sweep lowers the leave-one-out error at least: one percent.
const GAIN_OF_ERROR: f64 = 0.01;
/// Points among which the evidence is maximised: its cost grows with their cube, and more change the lengths little.
const MOST_SEARCHED: usize = 200;
/// Groups up to which each is left out alone; beyond, [`FOLDS`] parts are left out in turn.
const MOST_ALONE: usize = 50;
/// Parts of cross-validation.
const FOLDS: usize = 10;

/// Trend, lengths and nugget of least leave-one-out error.
pub(super) fn fit_process(points: &DMatrix<f64>, targets: &DMatrix<f64>) -> Option<Fitted> {
    let fits = of_each_trend(points, |trend, exponents| {
        let solve = |at: &[f64]| Conditional::new(points, exponents, at)?.fitted(trend, targets);
        let error = |at: &[f64]| solve(at).map(|fit| fit.leave_one_out.ln());
        solve(&search(start(points.ncols()), FIRST_STEP, GAIN_OF_ERROR, error)?)
    });
    fits.into_iter().next()
}

/// Lengths and nugget of largest evidence for each trend, the least leave-one-out error first. Empty if `step` ends it.
pub(super) fn fit_evidence(
    points: &DMatrix<f64>,
    targets: &DMatrix<f64>,
    step: &Step<'_>,
) -> Vec<Fitted> {
    of_each_trend(points, |trend, exponents| {
        step()?;
        let start = start(points.ncols());
        let at = maximise_evidence((points, targets), exponents, start, FIRST_STEP)?;
        Conditional::new(points, exponents, &at)?.fitted(trend, targets)
    })
}

/// Fits of the trends that there are enough points for, the least leave-one-out error first.
fn of_each_trend(
    points: &DMatrix<f64>,
    fit: impl Fn(usize, &[Vec<i32>]) -> Option<Fitted>,
) -> Vec<Fitted> {
    let fits = (0..=HIGHEST_TREND).filter_map(|trend| {
        // A trend of more than half as many coefficients as samples leaves little to the process.
        let exponents = monomials(points.ncols(), trend);
        let told = exponents.len() <= points.nrows() / 2 && are_told(points, &exponents);
        told.then(|| fit(trend, &exponents)).flatten()
    });
    let mut fits: Vec<_> = fits.collect();
    fits.sort_by(|a, b| a.leave_one_out.total_cmp(&b.leave_one_out));
    fits
}

/// Squared error over that of the best beyond which a process takes no part in the mean: its share would stay where the error of the best
/// is far below that of runs left out.
const WORST: f64 = 9.0;

/// Weights of the processes in their mean, inverse to their squared errors (Bates & Granger, "The combination of forecasts", 1969).
fn shares(processes: &[Fitted]) -> Vec<f64> {
    let errors = processes.iter().map(|fit| fit.leave_one_out.max(f64::MIN_POSITIVE));
    let least = errors.clone().fold(f64::INFINITY, f64::min);
    let precision = |error: f64| if error > WORST * least { 0.0 } else { least / error };
    let whole: f64 = errors.clone().map(precision).sum();
    errors.map(|error| precision(error) / whole).collect()
}

/// Weighted mean of processes at the same points, with hyperparameters and error of the first; `None` without one.
pub(super) fn mean(processes: &[Fitted]) -> Option<Fitted> {
    let best = processes.first()?;
    let exponents = processes.iter().map(|fit| &fit.basis.exponents).max_by_key(|e| e.len())?;
    let (points, exponents) = (best.basis.points.clone(), exponents.clone());
    let (samples, kernels) = (points.nrows(), points.nrows() * processes.len());
    let mut weights = DMatrix::zeros(kernels + exponents.len(), best.weights.ncols());
    for (place, (fit, share)) in processes.iter().zip(shares(processes)).enumerate() {
        let weighted = share * &fit.weights;
        weights.rows_mut(place * samples, samples).copy_from(&weighted.rows(0, samples));
        let mut sum = weights.rows_mut(kernels, fit.basis.exponents.len());
        sum += weighted.rows(samples, fit.basis.exponents.len());
    }
    let lengths = processes.iter().flat_map(|fit| fit.basis.lengths.clone()).collect();
    let basis = Basis { lengths, points, exponents };
    Some(Fitted { basis, weights, ..best.clone() })
}

/// Whether points tell these monomials apart.
fn are_told(points: &DMatrix<f64>, exponents: &[Vec<i32>]) -> bool {
    are_independent(&Basis::monomials(exponents.to_vec()).at_all(points))
}

/// Logarithms of lengths and nugget, which a search changes.
pub(super) fn logarithms(lengths: &[f64], nugget: f64) -> Vec<f64> {
    lengths.iter().copied().chain([nugget]).map(f64::ln).collect()
}

/// Logarithms of lengths and nugget that a search starts from.
fn start(variables: usize) -> Vec<f64> {
    (0..=variables).map(|d| bounds(d, variables).1).collect()
}

fn bounds(place: usize, variables: usize) -> (f64, f64, f64) {
    if place < variables { LOG_LENGTH } else { LOG_NUGGET }
}

/// Logarithms of lengths and nugget at a minimum of an objective, by a pattern search whose first step is `step`. A sweep takes all
/// changes that gain, or the best where they gain less together, so that the order of the parameters changes nothing. One that gains less
/// than `gain` is not worth another at its step.
fn search(
    mut at: Vec<f64>,
    mut step: f64,
    gain: f64,
    objective: impl Fn(&[f64]) -> Option<f64>,
) -> Option<Vec<f64>> {
    let variables = at.len() - 1;
    let mut best = objective(&at)?;
    // Steps down to e^⅛: finer ones change the error by a few percent only.
    while step >= 0.125 {
        let changes = (0..=variables).flat_map(|d| [(d, step), (d, -step)]);
        let trials = changes.filter_map(|(d, change)| {
            let (low, _, high) = bounds(d, variables);
            let mut trial = at.clone();
            trial[d] = (at[d] + change).clamp(low, high);
            Some((objective(&trial)?, d, trial[d]))
        });
        let mut gains: Vec<_> = trials.filter(|(value, ..)| *value < best).collect();
        gains.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (before, mut all) = (best, at.clone());
        gains.iter().for_each(|&(_, d, to)| all[d] = to);
        if let Some(&(value, d, to)) = gains.last() {
            match objective(&all) {
                Some(whole) if whole < value => (at, best) = (all, whole),
                _ => (at[d], best) = (to, value),
            }
        }
        step /= if best < before - gain { 1.0 } else { 2.0 };
    }
    Some(at)
}

/// Logarithms of lengths and nugget of largest evidence, among the first points.
fn maximise_evidence(
    (points, targets): (&DMatrix<f64>, &DMatrix<f64>),
    exponents: &[Vec<i32>],
    start: Vec<f64>,
    step: f64,
) -> Option<Vec<f64>> {
    // A parameter one standard deviation off its optimum lowers the log evidence by one half.
    const GAIN: f64 = 0.5;
    let count = points.nrows().min(MOST_SEARCHED);
    let [points, targets] = [points, targets].map(|all| all.rows(0, count).into_owned());
    let objective = |at: &[f64]| {
        Some(Conditional::new(&points, exponents, at)?.negative_log_evidence(&targets))
    };
    search(start, step, GAIN, objective)
}

/// Called once for each of the [`steps`] of a fit by evidence; `None` ends it.
pub(crate) type Step<'a> = dyn Fn() -> Option<()> + Sync + 'a;

/// Steps of a fit by evidence with its errors.
pub(crate) fn steps(partitions: &[Groups]) -> usize {
    let folds = partitions.iter().map(|groups| folds(groups.len()));
    HIGHEST_TREND + 1 + folds.sum::<usize>()
}

/// Parts of so many groups that are left out in turn.
pub(crate) fn folds(groups: usize) -> usize {
    if groups <= MOST_ALONE { groups } else { FOLDS }
}

/// Errors of samples that the [`mean`] of processes predicts from the others, and the deviations of the first
/// ([`Conditional::deviation`]) there, with their numbers. Groups are left out in turn, with trends that the others tell. Where these are
/// single samples, lengths and nuggets are fitted anew without each: the errors by which they were chosen are too small. Few levels less
/// one do not tell them.
pub(super) fn left_out(
    points: &DMatrix<f64>,
    targets: &DMatrix<f64>,
    processes: &[Fitted],
    groups: &Groups,
    step: &Step<'_>,
) -> Option<Vec<(usize, RowDVector<f64>, f64)>> {
    let (folds, are_alone) = (folds(groups.len()), groups.len() == points.nrows());
    let shares = shares(processes);
    // Lengths that few samples have chosen hold something of each of them: a search begins anew. It may end elsewhere, above all where values
    // have noise: the smaller of both deviations, which demands the wider interval, counts.
    let (few, begin) = (groups.len() <= MOST_ALONE, (start(points.ncols()), FIRST_STEP));
    let of_fold = |fold: usize| {
        step()?;
        let out: Vec<usize> = groups.iter().skip(fold).step_by(folds).flatten().copied().collect();
        let kept: Vec<usize> = (0..points.nrows()).filter(|i| !out.contains(i)).collect();
        let [x, y] = [points, targets].map(|all| all.select_rows(&kept));
        let without = |process: &Fitted| {
            let Interpolation::GaussianProcess { trend, lengths, nugget } = &process.interpolation
            else {
                return None;
            };
            let own = logarithms(lengths, *nugget);
            let trends = (0..=*trend).rev().map(|trend| (trend, monomials(x.ncols(), trend)));
            let is_told = |told: &Vec<_>| told.len() < x.nrows() && are_told(&x, told);
            let (trend, exponents) = trends.into_iter().find(|(_, told)| is_told(told))?;
            let search = || {
                let (from, step) =
                    if few { begin.clone() } else { (own.clone(), FIRST_STEP / 4.0) };
                maximise_evidence((&x, &y), &exponents, from, step)
            };
            let at = if are_alone { search()? } else { own.clone() };
            let [of_all, of_fold] = [&own, &at].map(|at| Conditional::new(&x, &exponents, at));
            let (of_all, of_fold) = (of_all?, of_fold?);
            Some((of_fold.fitted(trend, &y)?, [of_all, of_fold]))
        };
        let fits = processes.iter().map(without).collect::<Option<Vec<_>>>()?;
        let (_, best) = fits.first()?;
        let error = |i: usize| {
            let (x, y) = (points.row(i).into_owned(), targets.row(i));
            let parts = fits.iter().zip(&shares).map(|((fit, _), share)| *share * fit.at(&x));
            let deviation =
                best.iter().map(|process| process.deviation(&x)).fold(f64::MAX, f64::min);
            (i, parts.fold(-y, |sum, part| sum + part), deviation)
        };
        Some(out.into_iter().map(error).collect::<Vec<_>>())
    };
    let found = try_in_parallel(0..folds, |fold| of_fold(fold).ok_or(()));
    Some(found.ok()?.concat())
}

/// Covariance of points, with the generalised least squares of a polynomial (Rasmussen & Williams, 2006, section 2.7).
#[derive(Clone, Debug)]
pub(crate) struct Conditional {
    basis: Basis,
    nugget: f64,
    /// Factor of the covariance C.
    factor: Cholesky<f64, Dyn>,
    /// Values of the monomials P, one row per point.
    polynomial: DMatrix<f64>,
    /// C⁻¹ P.
    weighted: DMatrix<f64>,
    /// Factor of Pᵀ C⁻¹ P.
    schur: Cholesky<f64, Dyn>,
}

impl Conditional {
    pub(super) fn new(
        points: &DMatrix<f64>,
        exponents: &[Vec<i32>],
        logarithms: &[f64],
    ) -> Option<Self> {
        let (log_nugget, log_lengths) = logarithms.split_last()?;
        let lengths = log_lengths.iter().map(|l| l.exp()).collect();
        let basis = Basis { lengths, points: points.clone(), exponents: exponents.to_vec() };
        let (samples, nugget) = (basis.points.nrows(), log_nugget.exp());
        let values = basis.at_all(&basis.points);
        let mut covariance = values.columns(0, samples).into_owned();
        (0..samples).for_each(|i| covariance[(i, i)] += nugget);
        let polynomial = values.columns(samples, basis.exponents.len()).into_owned();
        let factor = Cholesky::new(covariance)?;
        let weighted = factor.solve(&polynomial);
        let schur = Cholesky::new(polynomial.tr_mul(&weighted))?;
        Some(Self { basis, nugget, factor, polynomial, weighted, schur })
    }

    /// Weights of the kernels and coefficients of the polynomial.
    fn weights(&self, targets: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        let coefficients = self.schur.solve(&self.weighted.tr_mul(targets));
        let kernels = self.factor.solve(&(targets - &self.polynomial * &coefficients));
        (kernels, coefficients)
    }

    /// Minus the logarithm of the evidence but for a constant, the variance at its maximum and the coefficients of the polynomial
    /// integrated out (Rasmussen & Williams, 2006, (2.45)); per column of the targets.
    fn negative_log_evidence(&self, targets: &DMatrix<f64>) -> f64 {
        let (kernels, coefficients) = self.weights(targets);
        let freedom = (targets.nrows() - coefficients.nrows()) as f64;
        let half_log_determinant = |factor: &Cholesky<f64, Dyn>| {
            factor.l_dirty().diagonal().iter().map(|pivot| pivot.ln()).sum::<f64>()
        };
        0.5 * freedom * targets.dot(&kernels).max(f64::MIN_POSITIVE).ln()
            + half_log_determinant(&self.factor)
            + half_log_determinant(&self.schur)
    }

    /// The process about the polynomial, whose coefficients are unknown, and its leave-one-out sum of squares (Dubrule, "Cross
    /// validation of kriging in a unique neighborhood", 1983).
    pub(super) fn fitted(&self, trend: usize, targets: &DMatrix<f64>) -> Option<Fitted> {
        let (kernels, coefficients) = self.weights(targets);
        let (samples, weighted) = (targets.nrows(), &self.weighted);
        // The diagonal of the inverse of the covariance bordered by the polynomial.
        let (inverse, explained) = (self.factor.inverse(), self.schur.solve(&weighted.transpose()));
        let squares = kernels.row_iter().enumerate().map(|(i, row)| {
            let diagonal = inverse[(i, i)] - weighted.row(i).transpose().dot(&explained.column(i));
            row.norm_squared() / diagonal.powi(2)
        });
        let leave_one_out = squares.sum::<f64>();
        let mut weights = kernels.resize_vertically(samples + coefficients.nrows(), 0.0);
        weights.rows_mut(samples, coefficients.nrows()).copy_from(&coefficients);
        let (basis, nugget) = (self.basis.clone(), self.nugget);
        let lengths = basis.lengths.clone();
        let interpolation = Interpolation::GaussianProcess { trend, lengths, nugget };
        leave_one_out.is_finite().then_some(Fitted { interpolation, basis, weights, leave_one_out })
    }

    /// Standard deviation of a new value at a point \[that of the process\] (Rasmussen & Williams, 2006, (2.42)).
    pub(super) fn deviation(&self, x: &RowDVector<f64>) -> f64 {
        (self.nugget + self.variance(&self.basis.at(x)).0.max(0.0)).sqrt()
    }

    /// [`Conditional::deviation`], and its derivatives by the coordinates of the point.
    pub(super) fn deviation_slopes(&self, x: &RowDVector<f64>) -> (f64, RowDVector<f64>) {
        let functions = self.basis.at(x);
        let (variance, by_functions) = self.variance(&functions);
        let deviation = (self.nugget + variance.max(0.0)).sqrt();
        // Rounding takes the variance at a sample below zero.
        let factor = if variance > 0.0 { 0.5 / deviation } else { 0.0 };
        (deviation, factor * by_functions.transpose() * self.basis.slopes(x, &functions))
    }

    /// Variance of the process where the basis has these values, and its derivatives by them.
    fn variance(&self, values: &RowDVector<f64>) -> (f64, DVector<f64>) {
        let values = values.transpose();
        let samples = self.basis.points.nrows();
        let kernels = values.rows(0, samples).into_owned();
        let monomials = values.rows(samples, self.basis.exponents.len());
        let rest = monomials - self.weighted.tr_mul(&kernels);
        let (explained, missed) = (self.factor.solve(&kernels), self.schur.solve(&rest));
        let variance = 1.0 - kernels.dot(&explained) + rest.dot(&missed);
        let mut slopes = DVector::zeros(values.len());
        slopes.rows_mut(0, samples).copy_from(&(-2.0 * (explained + &self.weighted * &missed)));
        slopes.rows_mut(samples, missed.len()).copy_from(&(2.0 * missed));
        (variance, slopes)
    }
}
