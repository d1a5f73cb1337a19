//! Regression: proper orthogonal decomposition of a few finite-element solutions, and interpolation of its coefficients
//! over the parameters.
//!
//! On one geometry a body's displacement is a smooth function of a handful of parameters, so a few dozen solutions span
//! nearly all others: the best emulator of a fixed geometry (docs/design.md).
//!
//! 1. The training fields, less their mean, are decomposed into orthonormal modes (Sirovich,
//!    "Turbulence and the dynamics of coherent structures", 1987); the leading ones are kept.
//! 2. Their coefficients are regressed on `x`, the parameters on the scale of their sampling with mean zero and
//!    variance one over their ranges, by a polynomial with a ridge penalty and by Gaussian processes about
//!    polynomial trends. Hyperparameters, and which of them is used, are decided by the leave-one-out error, which
//!    all have in closed form. The modes are orthonormal, so that is an error of the field.

mod design;
mod interpolation;
mod matrix;
mod process;

pub(crate) use design::{Groups, doubts, levels, partitions};
pub use interpolation::Interpolation;
pub(crate) use process::{Conditional, Step, folds, steps};

use crate::error::{ensure, require_usable};
use crate::sample::{WIDTH, share_of};
use crate::store::{content, read_json, read_table, write_json, write_table};
use crate::{Error, Result};
use interpolation::{Fitted, fit_polynomial};
use nalgebra::{DMatrix, DVector, RowDVector, SymmetricEigen};
use process::{fit_evidence, fit_process, left_out, mean};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sinew_energy::Parameter;
use std::path::Path;

/// Modes are dropped from the last on while the dropped share of the fields' sum of squares about their mean stays
/// within this.
const DROPPED_ENERGY: f64 = 1e-14;
/// Largest total degree of the polynomial. Lower ones are tried too, and only those with fewer coefficients than there
/// are samples.
const HIGHEST_DEGREE: usize = 4;
/// Accuracy of eigenvalues, nalgebra's own, and sweeps that no matrix needs.
const DECOMPOSITION: (f64, usize) = (5.0 * f64::EPSILON, 10_000);

/// Parameters, a vector of their values for each sample, and a field for each.
type Samples<'a> = (&'a [Parameter], &'a [Vec<f64>], &'a [Vec<f64>]);
/// Errors of samples left out, with the deviations of the process there.
type Errors = Vec<(f64, f64)>;

/// Proper orthogonal decomposition of few finite-element solutions, and interpolation between them.
///
/// ```
/// use sinew_emulate::PodRegression;
/// use sinew_energy::Parameter;
///
/// let stiffness = Parameter::log("k", "kPa", 1.0..=3.0);
/// let thetas: Vec<Vec<f64>> = (0..9).map(|i| vec![1.0 + 0.25 * i as f64]).collect();
/// let fields: Vec<Vec<f64>> = thetas.iter().map(|t| vec![5.0 / t[0], t[0].ln()]).collect();
/// let regression = PodRegression::fit(&[stiffness], &thetas, &fields)?;
/// let field = regression.predict(&[2.6])?;
/// assert!((field[0] - 5.0 / 2.6).abs() < 1e-4 && (field[1] - 2.6f64.ln()).abs() < 1e-4);
/// # Ok::<(), sinew_emulate::Error>(())
/// ```
#[doc(alias("ROM", "reduced-order model", "POD", "proper orthogonal decomposition"))]
#[derive(Clone, Debug, PartialEq)]
pub struct PodRegression {
    mean: DVector<f64>,
    /// One orthonormal mode per column.
    modes: DMatrix<f64>,
    parameters: Vec<Parameter>,
    fitted: Fitted,
    leave_one_out: f64,
}

/// Numbers of a [`PodRegression`]: `field = mean + Σ_k c_k mode_k` with `c = φ(x) W`.
///
/// The inputs are `x_d = √12 (s_d − ½)` with the share `s_d` of θ_d in its range, on the scale of its sampling. The functions φ are
/// first the kernels `exp(−½ Σ_d (x_d − p_d)²/ℓ_d²)` about the points p, for each set of lengths ℓ, then the monomials `Π_d x_d^e_d`.
#[derive(Clone, Debug, PartialEq)]
pub struct RegressionParts<'a> {
    /// Mean field \[unit of the field\].
    pub mean: &'a [f64],
    /// Orthonormal modes, each as long as the field.
    pub modes: Vec<&'a [f64]>,
    /// Lengths ℓ of the kernels, one per parameter, set after set; empty for a polynomial.
    pub lengths: &'a [f64],
    /// Points p, a row of one number per parameter for every kernel of a set.
    pub points: Vec<Vec<f64>>,
    /// Exponents e, a row of one number per parameter for every monomial.
    pub exponents: &'a [Vec<i32>],
    /// Weights W, a row of one number per mode for every function.
    pub weights: Vec<Vec<f64>>,
}

impl PodRegression {
    /// Fits to `thetas`, one vector of the named parameters per sample, and `fields`, for each the flattened
    /// displacement of all nodes \[length\].
    ///
    /// # Errors
    /// When samples are too few, differ in length, or hold a value that is not usable.
    pub fn fit(parameters: &[Parameter], thetas: &[Vec<f64>], fields: &[Vec<f64>]) -> Result<Self> {
        Self::fit_by((parameters, thetas, fields), |points, coefficients| {
            let polynomial = fit_polynomial(points, coefficients, HIGHEST_DEGREE);
            match fit_process(points, coefficients) {
                Some(process) if process.leave_one_out < polynomial.leave_one_out => process,
                _ => polynomial,
            }
        })
    }

    /// [`PodRegression::fit`] by a polynomial alone, of a total degree up to `degree`: for hundreds of samples, where a Gaussian
    /// process takes minutes to fit.
    ///
    /// # Errors
    /// As [`PodRegression::fit`].
    pub fn fit_polynomial(
        parameters: &[Parameter],
        thetas: &[Vec<f64>],
        fields: &[Vec<f64>],
        degree: usize,
    ) -> Result<Self> {
        Self::fit_by((parameters, thetas, fields), |points, coefficients| {
            fit_polynomial(points, coefficients, degree)
        })
    }

    /// [`PodRegression::fit`] by the mean of the Gaussian processes of largest evidence about each trend. For each partition also the error of each sample that is
    /// predicted from others, of fields its norm with what the modes lose, and [`PodRegression::deviation`] there. Samples are to be in
    /// random order.
    ///
    /// # Errors
    /// As [`PodRegression::fit`].
    pub(crate) fn fit_evidence(
        samples: Samples<'_>,
        partitions: &[Groups],
        step: &Step<'_>,
    ) -> Result<(Self, Vec<Errors>)> {
        let mut errors = None;
        let regression = Self::fit_by(samples, |points, coefficients| {
            let processes = fit_evidence(points, coefficients, step);
            let left = |groups| left_out(points, coefficients, &processes, groups, step);
            errors = partitions.iter().map(left).collect::<Option<Vec<_>>>();
            mean(&processes).unwrap_or_else(|| fit_polynomial(points, coefficients, 0))
        })?;
        let is_number = regression.modes.shape() == (1, 1);
        let fields = if is_number { &[] } else { samples.2 };
        let lost: Vec<f64> = fields.par_iter().map(|field| regression.lost(field)).collect();
        let error = |(sample, left, deviation): (usize, RowDVector<f64>, f64)| {
            let signed = || left[0] * regression.modes[(0, 0)];
            let norm = || left.norm().hypot(lost[sample]);
            (if is_number { signed() } else { norm() }, deviation)
        };
        let errors = errors.ok_or_else(|| too_few(samples.2.len()))?;
        let errors = errors.into_iter().map(|left| left.into_iter().map(error).collect());
        let errors = errors.collect();
        Ok((regression, errors))
    }

    /// Norm of what the modes lose of a field.
    fn lost(&self, field: &[f64]) -> f64 {
        let centred = DVector::from_column_slice(field) - &self.mean;
        let told = self.modes.tr_mul(&centred);
        (centred - &self.modes * told).norm()
    }

    /// Covariance of the samples; `None` without a Gaussian process.
    pub(crate) fn conditional(&self) -> Option<Conditional> {
        self.fitted.conditional(&self.fitted.basis.points)
    }

    /// Standard deviation of a mode's coefficient at θ \[that of the process\].
    pub(crate) fn deviation(&self, conditional: &Conditional, theta: &[f64]) -> f64 {
        conditional.deviation(&inputs(&self.parameters, theta))
    }

    /// Value and deviation of a number at shares of the ranges of the parameters, with derivatives by the shares.
    pub(crate) fn slopes(&self, conditional: &Conditional, shares: &[f64]) -> [(f64, Vec<f64>); 2] {
        let x = RowDVector::from_iterator(shares.len(), shares.iter().map(|&s| input(s)));
        let weights = &self.fitted.weights * self.modes.transpose();
        let functions = self.fitted.basis.at(&x);
        let value = self.mean[0] + (&functions * &weights)[0];
        let value_slopes = weights.tr_mul(&self.fitted.basis.slopes(&x, &functions));
        let (deviation, slopes) = conditional.deviation_slopes(&x);
        let by_share = |slopes: &[f64]| slopes.iter().map(|slope| WIDTH * slope).collect();
        [(value, by_share(value_slopes.as_slice())), (deviation, by_share(slopes.as_slice()))]
    }

    fn fit_by(
        samples: Samples<'_>,
        fit: impl FnOnce(&DMatrix<f64>, &DMatrix<f64>) -> Fitted,
    ) -> Result<Self> {
        check_samples(samples)?;
        let (parameters, thetas, fields) = samples;
        let snapshots = snapshots(fields);
        let (mean, [modes, coefficients]) = decompose(&snapshots)?;
        let fitted = fit(&points(parameters, thetas), &coefficients);
        let leave_one_out = fitted.relative_error(snapshots.norm_squared());
        let parameters = parameters.to_vec();
        Ok(Self { mean, modes, parameters, fitted, leave_one_out })
    }

    /// Fitted to more samples, with the modes and the hyperparameters of this one: a hundredth of the time of [`PodRegression::fit`].
    ///
    /// # Errors
    /// As [`PodRegression::fit`].
    pub fn refitted(&self, thetas: &[Vec<f64>], fields: &[Vec<f64>]) -> Result<Self> {
        check_samples((&self.parameters, thetas, fields))?;
        let snapshots = snapshots(fields);
        let coefficients = centred(&snapshots, &self.mean).tr_mul(&self.modes);
        let fitted = self.fitted.refitted(&points(&self.parameters, thetas), &coefficients);
        let fitted = fitted.ok_or_else(|| undecomposed(&snapshots))?;
        let leave_one_out = fitted.relative_error(snapshots.norm_squared());
        Ok(Self { fitted, leave_one_out, ..self.clone() })
    }

    /// The field at `theta`, flattened as the training fields were.
    ///
    /// # Errors
    /// When `theta` has another length than in training, or a value that its scale has no place for.
    pub fn predict(&self, theta: &[f64]) -> Result<Vec<f64>> {
        let mut field = self.mean.clone();
        field.gemv(1.0, &self.modes, &self.coefficients(theta)?.into(), 1.0);
        Ok(field.as_slice().to_vec())
    }

    /// Number of modes kept.
    pub fn modes(&self) -> usize {
        self.modes.ncols()
    }

    /// Interpolation with the lowest leave-one-out error, and its hyperparameters.
    pub fn interpolation(&self) -> &Interpolation {
        &self.fitted.interpolation
    }

    /// Leave-one-out error of the regression: root mean square norm of the field's error relative
    /// to that of the fields. It uses the modes of all samples and hyperparameters chosen by
    /// itself, so it is a little optimistic.
    pub fn leave_one_out(&self) -> f64 {
        self.leave_one_out
    }

    /// Writes a folder with all that prediction needs.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, folder: &Path) -> Result<()> {
        let mean = std::iter::once(self.mean.as_slice().to_vec());
        let modes = self.modes.column_iter().map(|mode| mode.as_slice().to_vec());
        write_table(&folder.join("modes.npy"), &mean.chain(modes).collect::<Vec<_>>())?;
        let (fitted, leave_one_out) = ([self.fitted.clone()], self.leave_one_out);
        write_json(&folder.join("regression.json"), &Description { fitted, leave_one_out })
    }

    /// Reads what [`PodRegression::save`] wrote, for the parameters that it was fitted with.
    ///
    /// # Errors
    /// A file that is missing or damaged.
    pub fn load(folder: &Path, parameters: &[Parameter]) -> Result<Self> {
        let (file, table) = (folder.join("regression.json"), folder.join("modes.npy"));
        let Description { fitted: [fitted], leave_one_out } =
            read_json(&file)?.ok_or_else(|| Error::NoEmulator { folder: folder.into() })?;
        let rows = read_table(&table)?;
        let length = rows.first().map_or(0, Vec::len);
        let modes = rows.len().saturating_sub(1);
        let fault = content(&table, &"it does not hold one mode per column of weights");
        ensure(length > 0 && fitted.weights.ncols() == modes, fault)?;
        Ok(Self {
            mean: DVector::from_column_slice(&rows[0]),
            modes: DMatrix::from_fn(length, modes, |i, j| rows[1 + j][i]),
            parameters: parameters.to_vec(),
            fitted,
            leave_one_out,
        })
    }

    /// The numbers that [`PodRegression::predict`] reads.
    pub fn parts(&self) -> RegressionParts<'_> {
        let basis = &self.fitted.basis;
        let rows = |matrix: &DMatrix<f64>| {
            matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
        };
        RegressionParts {
            mean: self.mean.as_slice(),
            modes: self.modes.as_slice().chunks_exact(self.mean.len().max(1)).collect(),
            lengths: &basis.lengths,
            points: rows(&basis.points),
            exponents: &basis.exponents,
            weights: rows(&self.fitted.weights),
        }
    }

    /// Coefficients of the modes at θ.
    ///
    /// # Errors
    /// As [`PodRegression::predict`].
    pub fn coefficients(&self, theta: &[f64]) -> Result<Vec<f64>> {
        check_theta(0, &self.parameters, theta)?;
        Ok(self.fitted.at(&inputs(&self.parameters, theta)).iter().copied().collect())
    }
}

#[derive(Serialize, Deserialize)]
struct Description {
    /// One for all modes.
    fitted: [Fitted; 1],
    leave_one_out: f64,
}

/// θ on the scale of its sampling, with mean zero and variance one over its ranges.
fn inputs(parameters: &[Parameter], theta: &[f64]) -> RowDVector<f64> {
    let shares = parameters.iter().zip(theta).map(|(p, &value)| input(share_of(p, value)));
    RowDVector::from_iterator(theta.len(), shares)
}

/// [`inputs`] at each of some θ, one per row.
pub(crate) fn points(parameters: &[Parameter], thetas: &[Vec<f64>]) -> DMatrix<f64> {
    let rows = thetas.iter().map(|theta| inputs(parameters, theta));
    DMatrix::from_rows(&rows.collect::<Vec<_>>())
}

fn input(share: f64) -> f64 {
    WIDTH * (share - 0.5)
}

pub(crate) fn check_samples((parameters, thetas, fields): Samples<'_>) -> Result<()> {
    let (found, count) = (thetas.len(), fields.len());
    require_usable(found == count, || {
        format!("{found} parameter vectors but {count} fields: give one field per vector")
    })?;
    ensure(found >= 2, too_few(found))?;
    for (sample, (theta, field)) in thetas.iter().zip(fields).enumerate() {
        check_theta(sample, parameters, theta)?;
        check_length(sample, "field values", field.len(), fields[0].len().max(1))?;
        for (index, value) in field.iter().enumerate() {
            require_usable(value.is_finite(), || {
                format!("value {index} of field {sample} is {value}: leave failed solves out")
            })?;
        }
    }
    Ok(())
}

fn too_few(found: usize) -> Error {
    Error::Refused(format!(
        "{found} simulations were given, at least 2 are needed, 25 is a good number"
    ))
}

fn check_theta(sample: usize, parameters: &[Parameter], theta: &[f64]) -> Result<()> {
    check_length(sample, "parameters", theta.len(), parameters.len())?;
    parameters.iter().zip(theta).try_for_each(|(parameter, value)| {
        require_usable(share_of(parameter, *value).is_finite(), || {
            let name = &parameter.name;
            format!(
                "parameter {name} of sample {sample} is {value}: it must be finite, and positive where it is sampled by its logarithm"
            )
        })
    })
}

fn check_length(sample: usize, what: &str, found: usize, expected: usize) -> Result<()> {
    require_usable(found == expected, || {
        format!("sample {sample}: {expected} {what} expected, {found} found")
    })
}

/// Fields in columns.
fn snapshots(fields: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(fields[0].len(), fields.len(), |i, j| fields[j][i])
}

fn centred(snapshots: &DMatrix<f64>, mean: &DVector<f64>) -> DMatrix<f64> {
    let mut centred = snapshots.clone();
    centred.column_iter_mut().for_each(|mut column| column -= mean);
    centred
}

fn undecomposed(snapshots: &DMatrix<f64>) -> Error {
    let ((length, samples), largest) = (snapshots.shape(), snapshots.amax());
    Error::Refused(format!(
        "no singular values of {samples} fields of {length} values, the largest being {largest:e}: choose units in which the values are of order one"
    ))
}

/// Left singular vectors and singular values, by eigenvectors of the smaller Gram matrix: nalgebra's singular vectors are wrong where
/// the rank is deficient. Orthonormal to rounding; values down to 1e-8 of the largest.
pub(crate) fn principal(matrix: &DMatrix<f64>) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let (transposed, is_wide) = (matrix.transpose(), matrix.ncols() > matrix.nrows());
    let gram = if is_wide { matrix * &transposed } else { &transposed * matrix };
    let (accuracy, sweeps) = DECOMPOSITION;
    let found = SymmetricEigen::try_new(gram, accuracy, sweeps)?;
    let mut order: Vec<usize> = (0..found.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| found.eigenvalues[b].total_cmp(&found.eigenvalues[a]));
    let vectors = found.eigenvectors.select_columns(&order);
    let images = if is_wide { transposed * &vectors } else { matrix * &vectors };
    let values = images.column_iter().map(|image| image.norm());
    let values = DVector::from_iterator(order.len(), values);
    Some((if is_wide { vectors } else { images.qr().q() }, values))
}

/// Mean of fields, orthonormal modes in columns, and coefficients of the modes, a row per sample: `field = mean + modes · coefficientsᵀ`.
fn decompose(snapshots: &DMatrix<f64>) -> Result<(DVector<f64>, [DMatrix<f64>; 2])> {
    let mean = snapshots.column_mean();
    let centred = centred(snapshots, &mean);
    let found = if centred.norm_squared().is_finite() { principal(&centred) } else { None };
    let (vectors, deviations) = found.ok_or_else(|| undecomposed(snapshots))?;
    let energies: Vec<f64> = deviations.iter().map(|s| s * s).collect();
    let allowed = DROPPED_ENERGY * energies.iter().sum::<f64>();
    let (mut dropped, mut kept) = (0.0, energies.len());
    // The rounding error of a zero singular value is not a mode, whatever the tolerance.
    let rounding = (f64::EPSILON * snapshots.norm()).powi(2);
    while kept > 0 && (dropped + energies[kept - 1] <= allowed || energies[kept - 1] <= rounding) {
        kept -= 1;
        dropped += energies[kept];
    }
    let modes = vectors.columns(0, kept).into_owned();
    let coefficients = centred.tr_mul(&modes);
    Ok((mean, [modes, coefficients]))
}
