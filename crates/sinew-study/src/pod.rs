//! The honest rival of the emulators: proper orthogonal decomposition of a few finite-element
//! solutions, and regression of its coefficients on the parameters.
//!
//! On one geometry a body's displacement is a smooth function of a handful of material
//! parameters, so a few dozen solutions span nearly all others. An emulator earns its training
//! time only where it does better than this: other geometries, no solutions, rough responses.
//!
//! 1. The training fields, less their mean, are decomposed into orthonormal modes (Sirovich,
//!    "Turbulence and the dynamics of coherent structures", 1987); the leading ones are kept.
//! 2. Their coefficients are regressed on `x`, the logarithms of the parameters standardised over
//!    the training points, by a polynomial with a ridge penalty and by a Gaussian process.
//!    Hyperparameters, and which of the two is used, are decided by the leave-one-out error, which
//!    both have in closed form. The modes are orthonormal, so that is an error of the field.

use std::fmt;

use nalgebra::{Cholesky, DMatrix, DVector, RowDVector};

/// How to fit a [`PodRegression`].
#[derive(Clone, Debug, PartialEq)]
pub struct PodConfig {
    /// Modes are dropped from the last on while the dropped share of the fields' sum of squares
    /// about their mean stays within this, in `[0, 1)`.
    pub energy_tolerance: f64,
    /// Largest total degree of the polynomial. Lower ones are tried too, and only those with fewer
    /// coefficients than there are samples.
    pub degree: usize,
}

impl PodConfig {
    /// Finite-element solutions to train on, unless a study says otherwise.
    pub const TRAINING_SOLVES: usize = 25;
}

impl Default for PodConfig {
    fn default() -> Self {
        Self { energy_tolerance: 1e-12, degree: 3 }
    }
}

/// Why a decomposition or its regression is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PodError {
    /// Too few samples.
    #[error("{found} samples were given, at least 2 are needed, 25 is a good number")]
    TooFewSamples {
        /// Samples given.
        found: usize,
    },
    /// Not one field per parameter vector.
    #[error("{thetas} parameter vectors but {fields} fields: give one field per vector")]
    SampleCount {
        /// Parameter vectors given.
        thetas: usize,
        /// Fields given.
        fields: usize,
    },
    /// Samples of unlike length.
    #[error("sample {sample}: {expected} {what} expected, as in the first one, {found} found")]
    Length {
        /// What was counted.
        what: &'static str,
        /// The sample.
        sample: usize,
        /// Length expected, at least 1.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// A parameter without a logarithm.
    #[error("parameter {parameter} of sample {sample} is {value}: it must be positive and finite")]
    Parameter {
        /// The sample.
        sample: usize,
        /// The parameter.
        parameter: usize,
        /// Its value.
        value: f64,
    },
    /// A field with a NaN or an infinity.
    #[error("value {index} of field {sample} is {value}: leave failed solves out")]
    Field {
        /// The sample.
        sample: usize,
        /// Index into the flattened field.
        index: usize,
        /// The value.
        value: f64,
    },
    /// The energy tolerance is not a share.
    #[error("the energy tolerance is {value}, it must be at least 0 and below 1: try 1e-12")]
    EnergyTolerance {
        /// The value given.
        value: f64,
    },
    /// The singular value decomposition failed.
    #[error(
        "no singular values of {samples} fields of {length} values, the largest being {largest:e}: \
         choose units in which the values are of order one"
    )]
    Decomposition {
        /// Fields.
        samples: usize,
        /// Values per field.
        length: usize,
        /// Largest magnitude of a value.
        largest: f64,
    },
}

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

/// POD and regression on few finite-element solutions.
#[derive(Clone, Debug)]
pub struct PodRegression {
    mean: DVector<f64>,
    /// One orthonormal mode per column.
    modes: DMatrix<f64>,
    log_mean: Vec<f64>,
    log_scale: Vec<f64>,
    fitted: Fitted,
    leave_one_out: f64,
}

/// A regression with what it needs to predict; one column of weights per mode.
#[derive(Clone, Debug)]
struct Fitted {
    regression: Regression,
    basis: Basis,
    weights: DMatrix<f64>,
    /// Sum over the samples of the squared error of the field.
    leave_one_out: f64,
}

/// The functions of `x` that the weights belong to.
#[derive(Clone, Debug)]
enum Basis {
    /// One row of exponents per monomial.
    Monomials(Vec<Vec<i32>>),
    /// Kernels with these lengths at the training points, one per row.
    Kernels { lengths: Vec<f64>, points: DMatrix<f64> },
}

impl PodRegression {
    /// Fits to `thetas`, one positive parameter vector per sample, and `fields`, for each the
    /// flattened displacement of all nodes, row by row [length unit of the scene].
    ///
    /// # Errors
    /// When samples are too few, differ in length, or hold a value that is not usable.
    pub fn fit(
        thetas: &[Vec<f64>],
        fields: &[Vec<f64>],
        config: &PodConfig,
    ) -> Result<Self, PodError> {
        check_samples(thetas, fields)?;
        if !(0.0..1.0).contains(&config.energy_tolerance) {
            return Err(PodError::EnergyTolerance { value: config.energy_tolerance });
        }
        let snapshots = DMatrix::from_fn(fields[0].len(), fields.len(), |i, j| fields[j][i]);
        let Decomposition { mean, modes, coefficients } =
            decompose(&snapshots, config.energy_tolerance)?;

        let logs = DMatrix::from_fn(thetas.len(), thetas[0].len(), |i, j| thetas[i][j].ln());
        let (log_mean, log_scale): (Vec<_>, Vec<_>) =
            logs.column_iter().map(|column| mean_and_scale(column.as_slice())).unzip();
        let points = DMatrix::from_fn(logs.nrows(), logs.ncols(), |i, j| {
            (logs[(i, j)] - log_mean[j]) / log_scale[j]
        });
        let polynomial = fit_polynomial(&points, &coefficients, config.degree);
        let process = fit_process(&points, &coefficients);
        let fitted = match process {
            Some(process) if process.leave_one_out < polynomial.leave_one_out => process,
            _ => polynomial,
        };
        let (error, size) = (fitted.leave_one_out, snapshots.norm_squared());
        let leave_one_out = if size > 0.0 { (error / size).sqrt() } else { 0.0 };
        Ok(Self { mean, modes, log_mean, log_scale, fitted, leave_one_out })
    }

    /// The field at `theta`, flattened as the training fields were.
    ///
    /// # Errors
    /// When `theta` has another length than in training, or a value that is not positive.
    pub fn predict(&self, theta: &[f64]) -> Result<Vec<f64>, PodError> {
        check_theta(0, theta, self.log_mean.len())?;
        let standardise = |d: usize| (theta[d].ln() - self.log_mean[d]) / self.log_scale[d];
        let x = RowDVector::from_fn(theta.len(), |_, d| standardise(d));
        let coefficients = self.fitted.basis.at(&x) * &self.fitted.weights;
        Ok((&self.mean + &self.modes * coefficients.transpose()).as_slice().to_vec())
    }

    /// Number of modes kept.
    pub fn modes(&self) -> usize {
        self.modes.ncols()
    }

    /// Which regression won, with its hyperparameters.
    pub fn regression(&self) -> &Regression {
        &self.fitted.regression
    }

    /// Leave-one-out error of the regression: root mean square norm of the field's error relative
    /// to that of the fields. It uses the modes of all samples and hyperparameters chosen by
    /// itself, so it is a little optimistic.
    pub fn leave_one_out(&self) -> f64 {
        self.leave_one_out
    }
}

fn check_samples(thetas: &[Vec<f64>], fields: &[Vec<f64>]) -> Result<(), PodError> {
    if thetas.len() != fields.len() {
        return Err(PodError::SampleCount { thetas: thetas.len(), fields: fields.len() });
    }
    if thetas.len() < 2 {
        return Err(PodError::TooFewSamples { found: thetas.len() });
    }
    for (sample, (theta, field)) in thetas.iter().zip(fields).enumerate() {
        check_theta(sample, theta, thetas[0].len().max(1))?;
        let (what, expected, found) = ("field values", fields[0].len().max(1), field.len());
        if found != expected {
            return Err(PodError::Length { what, sample, expected, found });
        }
        if let Some(index) = field.iter().position(|value| !value.is_finite()) {
            return Err(PodError::Field { sample, index, value: field[index] });
        }
    }
    Ok(())
}

fn check_theta(sample: usize, theta: &[f64], expected: usize) -> Result<(), PodError> {
    let (what, found) = ("parameters", theta.len());
    if found != expected {
        return Err(PodError::Length { what, sample, expected, found });
    }
    match theta.iter().position(|&value| !(value.is_finite() && value > 0.0)) {
        None => Ok(()),
        Some(parameter) => Err(PodError::Parameter { sample, parameter, value: theta[parameter] }),
    }
}

/// Scale 1 for a parameter that hardly varies: its logarithms differ by rounding alone.
fn mean_and_scale(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
    (mean, if deviation > 1e-12 { deviation } else { 1.0 })
}

/// Fields about their mean: `field = mean + modes · coefficientsᵀ`.
struct Decomposition {
    mean: DVector<f64>,
    /// One orthonormal mode per column.
    modes: DMatrix<f64>,
    /// One row per sample.
    coefficients: DMatrix<f64>,
}

fn decompose(snapshots: &DMatrix<f64>, energy_tolerance: f64) -> Result<Decomposition, PodError> {
    let mean = snapshots.column_mean();
    let mut centred = snapshots.clone();
    centred.column_iter_mut().for_each(|mut column| column -= &mean);
    let failed = || PodError::Decomposition {
        samples: snapshots.ncols(),
        length: snapshots.nrows(),
        largest: snapshots.amax(),
    };
    if !centred.norm_squared().is_finite() {
        return Err(failed());
    }
    // nalgebra's own accuracy, and more sweeps than any matrix needs instead of no bound.
    let svd =
        centred.clone().try_svd(true, false, 5.0 * f64::EPSILON, 10_000).ok_or_else(failed)?;
    let energies: Vec<f64> = svd.singular_values.iter().map(|s| s * s).collect();
    let allowed = energy_tolerance * energies.iter().sum::<f64>();
    let mut dropped = 0.0;
    let mut kept = energies.len();
    // What rounding leaves of a zero singular value is no mode, whatever the tolerance.
    let rounding = (f64::EPSILON * snapshots.norm()).powi(2);
    while kept > 0 && (dropped + energies[kept - 1] <= allowed || energies[kept - 1] <= rounding) {
        kept -= 1;
        dropped += energies[kept];
    }
    let modes = svd.u.ok_or_else(failed)?.columns(0, kept).into_owned();
    let coefficients = centred.tr_mul(&modes);
    Ok(Decomposition { mean, modes, coefficients })
}

impl Basis {
    /// The functions at one point.
    fn at(&self, x: &RowDVector<f64>) -> RowDVector<f64> {
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
    fn at_all(&self, points: &DMatrix<f64>) -> DMatrix<f64> {
        let rows: Vec<_> = points.row_iter().map(|x| self.at(&x.into_owned())).collect();
        DMatrix::from_rows(&rows)
    }
}

/// The degree and ridge of least leave-one-out error.
fn fit_polynomial(points: &DMatrix<f64>, targets: &DMatrix<f64>, degree: usize) -> Fitted {
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
fn monomials(variables: usize, degree: usize, most: usize) -> Option<Vec<Vec<i32>>> {
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

/// Bounds and start of the logarithms of the lengths: points have standard deviation 1.
const LOG_LENGTH: (f64, f64, f64) = (-3.0, 0.7, 4.6);
/// Bounds and start of the logarithm of the nugget: 1e-13 still factorises, 1 fits nothing.
const LOG_NUGGET: (f64, f64, f64) = (-30.0, -18.0, 0.0);

/// Lengths and nugget of least leave-one-out error, by a pattern search over their logarithms.
fn fit_process(points: &DMatrix<f64>, targets: &DMatrix<f64>) -> Option<Fitted> {
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
fn solve_process(
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

#[cfg(test)]
mod tests {
    use super::*;

    /// `count` points in `[low, high]^variables`, evenly spread by the additive recurrence of
    /// Roberts ("The unreasonable effectiveness of quasirandom sequences", 2018).
    fn points(count: usize, variables: usize, low: f64, high: f64) -> Vec<Vec<f64>> {
        let golden = (0..64).fold(2f64, |g, _| (1.0 + g).powf(1.0 / (variables + 1) as f64));
        let share = |i: usize, d: usize| (0.5 + (i + 1) as f64 / golden.powi(d as i32 + 1)).fract();
        let value = |i, d| low * (high / low).powf(share(i, d));
        (0..count).map(|i| (0..variables).map(|d| value(i, d)).collect()).collect()
    }

    /// A clamped beam's deflection in form: stiffness in the denominator, and some coupling.
    fn smooth(theta: &[f64]) -> Vec<f64> {
        let stiffness: f64 = theta.iter().sum();
        let ratio = theta[0] / stiffness;
        (0..60)
            .map(|i| {
                let s = i as f64 / 59.0;
                1e3 * s * s / stiffness + 5.0 * (3.0 * s * ratio).sin() + ratio * ratio * s
            })
            .collect()
    }

    fn relative_error(pod: &PodRegression, thetas: &[Vec<f64>]) -> f64 {
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let error = |theta: &Vec<f64>| {
            let (truth, guess) = (smooth(theta), pod.predict(theta).unwrap());
            let difference: Vec<f64> = truth.iter().zip(&guess).map(|(a, b)| a - b).collect();
            norm(&difference) / norm(&truth)
        };
        thetas.iter().map(error).fold(0.0, f64::max)
    }

    fn fit(thetas: &[Vec<f64>]) -> PodRegression {
        let fields: Vec<_> = thetas.iter().map(|theta| smooth(theta)).collect();
        PodRegression::fit(thetas, &fields, &PodConfig::default()).unwrap()
    }

    #[test]
    fn a_smooth_family_is_reproduced_and_interpolated() {
        let thetas = points(25, 2, 50.0, 100.0);
        let pod = fit(&thetas);
        let training = relative_error(&pod, &thetas);
        let between = relative_error(&pod, &points(60, 2, 55.0, 90.0));
        assert!(training < 1e-5, "{training:e} with {}", pod.regression());
        assert!(between < 1e-4, "{between:e} with {}", pod.regression());
        assert!(pod.leave_one_out() < 1e-4 && pod.modes() >= 3, "{}", pod.leave_one_out());
    }

    #[test]
    fn any_number_of_parameters() {
        let one = points(12, 1, 1.0, 3.0);
        assert!(relative_error(&fit(&one), &points(20, 1, 1.1, 2.8)) < 1e-4);
        let five = points(120, 5, 1.0, 1.5);
        let (pod, test) = (fit(&five), points(20, 5, 1.1, 1.4));
        assert!(relative_error(&pod, &test) < 1e-3, "{:e}", relative_error(&pod, &test));
    }

    #[test]
    fn a_cubic_family_is_recognised() {
        let thetas = points(25, 2, 1.0, 4.0);
        let field = |theta: &Vec<f64>| {
            let (a, b) = (theta[0].ln(), theta[1].ln());
            vec![a * a * b - 2.0, 3.0 * b * b * b + a, a * b]
        };
        let fields: Vec<_> = thetas.iter().map(field).collect();
        let pod = PodRegression::fit(&thetas, &fields, &PodConfig::default()).unwrap();
        assert!(matches!(pod.regression(), Regression::Polynomial { degree: 3, .. }));
        let theta = vec![1.7, 3.1];
        let guess = pod.predict(&theta).unwrap();
        for (truth, guess) in field(&theta).iter().zip(guess) {
            // A dropped share of 1e-12 of the energy is 1e-6 of the field, at most.
            assert!((truth - guess).abs() < 2e-6, "{truth} {guess}");
        }
    }

    #[test]
    fn too_few_samples_lower_the_degree() {
        for (samples, degree) in [(2, 0), (4, 1), (7, 2), (10, 2), (11, 3)] {
            let thetas = points(samples, 2, 1.0, 2.0);
            let targets = DMatrix::from_fn(samples, 1, |i, _| thetas[i][0].ln().powi(3));
            let x = DMatrix::from_fn(samples, 2, |i, d| 3.0 * thetas[i][d].ln() - 1.0);
            let highest =
                (0..=3).filter(|&d| d == 0 || monomials(2, d, samples - 1).is_some()).max();
            assert_eq!(highest, Some(degree), "{samples} samples");
            match fit_polynomial(&x, &targets, 3).regression {
                Regression::Polynomial { degree: used, .. } => assert!(used <= degree),
                other => panic!("{other}"),
            }
        }
        let two = fit(&points(2, 2, 50.0, 100.0));
        assert!(two.predict(&[60.0, 70.0]).unwrap().iter().all(|u| u.is_finite()));
    }

    #[test]
    fn leave_one_out_in_closed_form_is_the_one_by_refitting() {
        let thetas = points(9, 2, 1.0, 2.0);
        let x = DMatrix::from_fn(9, 2, |i, d| 3.0 * thetas[i][d].ln() - 1.0);
        let y = DMatrix::from_fn(9, 2, |i, j| (x[(i, 0)] + j as f64 * x[(i, 1)]).sin());
        let basis = Basis::Monomials(monomials(2, 2, 8).unwrap());
        let values = basis.at_all(&x);
        let logarithms = [0.3, 0.5, -9.0];
        let (mut polynomial, mut process) = (0.0, 0.0);
        for i in 0..9 {
            let (rest, targets) = (x.clone().remove_row(i), y.clone().remove_row(i));
            // The penalty is per sample; here it must stay that of nine.
            let (weights, _) =
                solve_ridge(&basis.at_all(&rest), &targets, 0.01 * 9.0 / 8.0).unwrap();
            polynomial += (values.row(i) * weights - y.row(i)).norm_squared();
            let fit = solve_process(&rest, &targets, &logarithms).unwrap();
            let guess = fit.basis.at(&x.row(i).into_owned()) * fit.weights;
            process += (guess - y.row(i)).norm_squared();
        }
        let closed = solve_ridge(&values, &y, 0.01).unwrap().1;
        assert!((closed / polynomial - 1.0).abs() < 1e-10);
        let closed = solve_process(&x, &y, &logarithms).unwrap().leave_one_out;
        assert!((closed / process - 1.0).abs() < 1e-8);
    }

    #[test]
    fn equal_fields_have_no_modes() {
        let thetas = points(5, 2, 1.0, 2.0);
        let fields = vec![vec![0.1, -0.2, 0.3]; 5];
        let pod = PodRegression::fit(&thetas, &fields, &PodConfig::default()).unwrap();
        assert_eq!(pod.modes(), 0);
        for (a, b) in pod.predict(&[1.5, 1.5]).unwrap().iter().zip(&fields[0]) {
            assert!((a - b).abs() < 1e-15);
        }
    }

    #[test]
    fn a_constant_parameter_does_no_harm() {
        let mut thetas = points(20, 2, 50.0, 100.0);
        thetas.iter_mut().for_each(|theta| theta[1] = 0.3);
        assert!(relative_error(&fit(&thetas), &thetas) < 1e-5);
    }

    #[test]
    fn unusable_samples() {
        let thetas = points(4, 2, 1.0, 2.0);
        let fields = vec![vec![1.0, 2.0], vec![2.0, 0.0], vec![0.0, 1.0], vec![1.0, 1.0]];
        let fit = |thetas: &[Vec<f64>], fields: &[Vec<f64>]| {
            PodRegression::fit(thetas, fields, &PodConfig::default())
        };
        let mut broken = fields.clone();
        broken[2][1] = f64::NAN;
        let error = fit(&thetas, &broken).unwrap_err();
        assert!(matches!(error, PodError::Field { sample: 2, index: 1, .. }));
        broken[2] = vec![0.0; 3];
        let error = fit(&thetas, &broken).unwrap_err();
        assert!(matches!(error, PodError::Length { sample: 2, expected: 2, found: 3, .. }));
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut thetas = thetas.clone();
            thetas[1][0] = value;
            let error = fit(&thetas, &fields).unwrap_err();
            assert!(matches!(error, PodError::Parameter { sample: 1, parameter: 0, .. }));
        }
        let error = fit(&thetas[..3], &fields).unwrap_err();
        assert_eq!(error, PodError::SampleCount { thetas: 3, fields: 4 });
        let error = fit(&thetas[..1], &fields[..1]).unwrap_err();
        assert_eq!(error, PodError::TooFewSamples { found: 1 });
        let huge: Vec<_> = fields.iter().map(|f| f.iter().map(|u| 1e200 * u).collect()).collect();
        assert!(matches!(fit(&thetas, &huge), Err(PodError::Decomposition { .. })));
        let config = PodConfig { energy_tolerance: 1.0, ..PodConfig::default() };
        let error = PodRegression::fit(&thetas, &fields, &config).unwrap_err();
        assert_eq!(error, PodError::EnergyTolerance { value: 1.0 });
        let pod = fit(&thetas, &fields).unwrap();
        assert!(matches!(pod.predict(&[1.0]), Err(PodError::Length { found: 1, .. })));
        assert!(matches!(pod.predict(&[1.0, -1.0]), Err(PodError::Parameter { .. })));
    }
}
