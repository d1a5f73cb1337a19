//! A regression as plain numbers, and as a folder: `modes.npy`, the mean and the modes row by row, and `regression.json`, the rest.

use crate::predict::regression::PodRegression;
use crate::predict::regression::interpolation::Fitted;
use crate::store::{content, read_json, read_table, write_json, write_table};
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use sinew_energy::Parameter;
use std::path::Path;

#[derive(Serialize, Deserialize)]
struct Description {
    /// One for all modes.
    fitted: [Fitted; 1],
    leave_one_out: f64,
}

impl PodRegression {
    /// Writes a folder with all that prediction needs.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, folder: &Path) -> Result<()> {
        let column = |column: &[f64]| column.to_vec();
        let mean = std::iter::once(column(self.mean.as_slice()));
        let modes = self.modes.column_iter().map(|mode| column(mode.as_slice()));
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
        if length == 0 || fitted.weights.ncols() != modes {
            return Err(content(&table, &"it does not hold one mode per column of weights"));
        }
        Ok(Self {
            mean: DVector::from_column_slice(&rows[0]),
            modes: DMatrix::from_fn(length, modes, |i, j| rows[1 + j][i]),
            parameters: parameters.to_vec(),
            fitted,
            leave_one_out,
        })
    }
}

/// Numbers of a [`PodRegression`]: `field = mean + Σ_k c_k mode_k` with `c = φ(x) W`.
///
/// The inputs are `x_d = √12 (s_d − ½)` with the share `s_d` of θ_d in its range, on the scale of its sampling. The functions φ are
/// first the kernels `exp(−½ Σ_d (x_d − p_d)²/ℓ_d²)` about the points p, then the monomials `Π_d x_d^e_d`.
#[derive(Clone, Debug, PartialEq)]
pub struct RegressionParts<'a> {
    /// Mean field \[unit of the field\].
    pub mean: &'a [f64],
    /// Orthonormal modes, each as long as the field.
    pub modes: Vec<&'a [f64]>,
    /// Lengths ℓ of the kernels, one per parameter; empty for a polynomial.
    pub lengths: &'a [f64],
    /// Points p, a row of one number per parameter for every kernel.
    pub points: Vec<Vec<f64>>,
    /// Exponents e, a row of one number per parameter for every monomial.
    pub exponents: &'a [Vec<i32>],
    /// Weights W, a row of one number per mode for every function.
    pub weights: Vec<Vec<f64>>,
}

impl PodRegression {
    /// The numbers that [`PodRegression::predict`] reads.
    pub fn parts(&self) -> RegressionParts<'_> {
        let basis = &self.fitted.basis;
        let rows = |matrix: &nalgebra::DMatrix<f64>| {
            matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
        };
        let length = self.mean.len();
        RegressionParts {
            mean: self.mean.as_slice(),
            modes: self.modes.as_slice().chunks_exact(length.max(1)).collect(),
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
    pub fn coefficients(&self, theta: &[f64]) -> Result<Vec<f64>, super::RegressionError> {
        super::check_theta(0, &self.parameters, theta)?;
        Ok(self.fitted.at(&super::inputs(&self.parameters, theta)).iter().copied().collect())
    }
}
