//! Size of displacement fields over the parameters.

use sinew_emulate::{PodRegression, RegressionError};
use sinew_energy::Parameter;

/// Largest total degree of the polynomial; lower ones are tried too.
const DEGREE: usize = 3;

/// Root mean square of displacement fields over the parameters, for data sets of many shapes: its logarithm is a polynomial of up to
/// third degree in the parameters on the scale of their sampling, by least squares.
///
/// Between soft and stiff tissue displacements differ by orders of magnitude. A network or regression that is trained on fields divided by
/// this size learns relative errors. That lowers errors where fields differ mostly in size, as of inflated ventricles
/// (`docs/populations.md`); where their shape changes fast with the size, fields as they are may be the better targets.
///
/// ```
/// use sinew_energy::Parameter;
/// use sinew_studies::populations::size::SizeRegression;
///
/// let stiffness = Parameter::log("k", "kPa", 0.1..=10.0);
/// let thetas: Vec<Vec<f64>> = (0..9).map(|i| vec![10f64.powf(0.25 * i as f64 - 1.0)]).collect();
/// let fields: Vec<Vec<f64>> = thetas.iter().map(|t| vec![5.0 / t[0], -5.0 / t[0]]).collect();
/// let sizes = SizeRegression::fit(&[stiffness], &thetas, &fields)?;
/// assert!((sizes.at(&[2.0])? - 2.5).abs() < 1e-6); // mm
/// # Ok::<(), sinew_emulate::RegressionError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SizeRegression(PodRegression);

impl SizeRegression {
    /// Fits to `thetas`, one vector of the named parameters per sample, and `fields`, for each the displacements of any number of nodes
    /// \[length\].
    ///
    /// # Errors
    /// As [`PodRegression::fit`]; a field of zeros is [`RegressionError::Field`], as its logarithm is not finite.
    pub fn fit<F: AsRef<[f64]>>(
        parameters: &[Parameter],
        thetas: &[Vec<f64>],
        fields: &[F],
    ) -> Result<Self, RegressionError> {
        let size = |field: &[f64]| {
            let square = field.iter().map(|u| u * u).sum::<f64>() / field.len() as f64;
            vec![0.5 * square.ln()]
        };
        let sizes: Vec<_> = fields.iter().map(|field| size(field.as_ref())).collect();
        Ok(Self(PodRegression::fit_polynomial(parameters, thetas, &sizes, DEGREE)?))
    }

    /// Size at `theta` \[length\].
    ///
    /// # Errors
    /// As [`PodRegression::predict`].
    pub fn at(&self, theta: &[f64]) -> Result<f64, RegressionError> {
        Ok(self.0.predict(theta)?[0].exp())
    }
}
