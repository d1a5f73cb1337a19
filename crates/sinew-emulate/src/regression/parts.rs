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

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_energy::Parameter;

    /// Sums of a few dozen products of size 1.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn a_field_is_the_sum_of_its_parts() {
        let parameters =
            [Parameter::log("k", "kPa", 1.0..=3.0), Parameter::linear("q", "1", 0.0..=2.0)];
        let thetas: Vec<Vec<f64>> = (0..30)
            .map(|i| vec![1.0 + 2.0 * (0.37 * i as f64).fract(), 2.0 * (0.61 * i as f64).fract()])
            .collect();
        let field = |t: &Vec<f64>| vec![5.0 / t[0], (t[0] * t[1]).sin(), t[1].exp(), t[0] + t[1]];
        let fields: Vec<_> = thetas.iter().map(field).collect();
        let by_process = PodRegression::fit(&parameters, &thetas, &fields).unwrap();
        let by_polynomial =
            PodRegression::fit_polynomial(&parameters, &thetas, &fields, 3).unwrap();
        assert!(by_polynomial.parts().lengths.is_empty() && by_polynomial.leave_one_out() < 0.02);
        for regression in [by_process, by_polynomial] {
            let (parts, theta) = (regression.parts(), [2.2_f64, 0.7]);
            let share = [theta[0].ln() / 3f64.ln(), theta[1] / 2.0];
            let x = share.map(|s| 12f64.sqrt() * (s - 0.5));
            let kernels = parts.points.iter().map(|p| {
                let square = |d: usize| ((x[d] - p[d]) / parts.lengths[d]).powi(2);
                (-0.5 * (square(0) + square(1))).exp()
            });
            let monomials = parts.exponents.iter().map(|e| x[0].powi(e[0]) * x[1].powi(e[1]));
            let functions: Vec<f64> = kernels.chain(monomials).collect();
            let mut sum = parts.mean.to_vec();
            for (k, mode) in parts.modes.iter().enumerate() {
                let c: f64 = functions.iter().zip(&parts.weights).map(|(f, row)| f * row[k]).sum();
                sum.iter_mut().zip(*mode).for_each(|(sum, m)| *sum += c * m);
            }
            let size = functions.iter().map(|f| f.abs()).sum::<f64>();
            let largest = parts.weights.iter().flatten().fold(1.0, |m: f64, w| m.max(w.abs()));
            for (own, predicted) in sum.iter().zip(regression.predict(&theta).unwrap()) {
                assert!((own - predicted).abs() < ROUNDING * size * largest, "{own} {predicted}");
            }
        }
    }
}
