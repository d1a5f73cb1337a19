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

mod decomposition;
mod error;
mod regression;

use nalgebra::{DMatrix, DVector, RowDVector};

use decomposition::{Decomposition, decompose};
pub use error::PodError;
pub use regression::Regression;
use regression::{Fitted, fit_polynomial, fit_process};

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

#[cfg(test)]
mod tests;
