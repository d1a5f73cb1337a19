//! The numbers of a regression, for evaluations in other languages.

use super::PodRegression;

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
