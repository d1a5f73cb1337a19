//! The rational-quadratic kernel.

use super::axes::Axes;
use super::radial::{Profile, Radial};
use super::{Hyperparameter, Measure};
use crate::series::Series;

/// (1 + s/α)^(−α) with s = ½ Σ (xᵢ − xᵢ′)² / λᵢ²: squared exponentials of many lengthscales at
/// once; infinitely smooth (Rasmussen & Williams 2006, eq. 4.19).
pub type RationalQuadratic = Radial<PowerLaw>;

impl RationalQuadratic {
    /// On all axes.
    pub fn new() -> Self {
        Self::default()
    }

    /// On the axes with these numbers only.
    pub fn along(axes: &[usize]) -> Self {
        Self { axes: Axes::only(axes), ..Self::new() }
    }
}

/// (1 + s/α)^(−α)
#[derive(Clone, Debug, Default)]
pub struct PowerLaw;

impl Profile for PowerLaw {
    fn name(&self) -> String {
        "rational-quadratic".into()
    }

    fn smoothness(&self) -> Option<usize> {
        None
    }

    fn own(&self) -> Vec<Hyperparameter> {
        let measure = Measure::Number { lower: 0.1, upper: 100.0 };
        vec![Hyperparameter { name: "shape", measure }]
    }

    fn formula(&self, s: Series, shape: &[Series]) -> Series {
        ((s / &shape[0] + 1.0).ln() * &shape[0] * -1.0).exp()
    }

    fn slopes(&self, s: f64, shape: &[f64], slopes: &mut [f64]) {
        let alpha = shape[0];
        let base = 1.0 + s / alpha;
        let mut value = base.powf(-alpha);
        for (m, slope) in slopes.iter_mut().enumerate() {
            *slope = value;
            value *= -(alpha + m as f64) / (alpha * base);
        }
    }

    fn slopes_by_own(&self, s: f64, shape: &[f64], slopes: &mut [f64]) {
        // The logarithm of the m-th derivative, up to its sign, is
        // Σ_{k<m} ln(α + k) − m ln α − (α + m) ln(1 + s/α).
        let alpha = shape[0];
        let base = 1.0 + s / alpha;
        let logarithm = (s / alpha).ln_1p();
        self.slopes(s, shape, slopes);
        let mut sum = 0.0;
        for (m, slope) in slopes.iter_mut().enumerate() {
            let m = m as f64;
            *slope *=
                alpha * (sum - m / alpha - logarithm + (alpha + m) * s / (alpha * alpha * base));
            sum += 1.0 / (alpha + m);
        }
    }
}
