//! The rational-quadratic kernel.

use sinew_num::Series;

use super::axes::Axes;
use super::radial::{self, Profile};
use super::squared_exponential::{half_square, lengthscales};
use super::{Hyperparameter, Kernel, Measure, Orders, Pairs};

/// (1 + s/α)^(−α) with s = ½ Σ (xᵢ − xᵢ′)² / λᵢ²: squared exponentials of many lengthscales at
/// once; infinitely smooth (Rasmussen & Williams 2006, eq. 4.19).
#[derive(Clone, Debug, Default)]
pub struct RationalQuadratic {
    axes: Axes,
}

impl RationalQuadratic {
    /// On all axes.
    pub fn new() -> Self {
        Self::default()
    }

    /// On the axes with these numbers only.
    pub fn along(axes: &[usize]) -> Self {
        Self { axes: Axes::only(axes) }
    }
}

struct PowerLaw {
    alpha: f64,
}

impl Profile for PowerLaw {
    fn slopes(&self, s: f64, slopes: &mut [f64]) {
        let base = 1.0 + s / self.alpha;
        let mut value = base.powf(-self.alpha);
        for (m, slope) in slopes.iter_mut().enumerate() {
            *slope = value;
            value *= -(self.alpha + m as f64) / (self.alpha * base);
        }
    }
}

/// ∂/∂ln α of the power law.
struct ByShape {
    alpha: f64,
}

impl Profile for ByShape {
    fn slopes(&self, s: f64, slopes: &mut [f64]) {
        // The logarithm of the m-th derivative, up to its sign, is
        // Σ_{k<m} ln(α + k) − m ln α − (α + m) ln(1 + s/α).
        let alpha = self.alpha;
        let base = 1.0 + s / alpha;
        let logarithm = (s / alpha).ln_1p();
        PowerLaw { alpha }.slopes(s, slopes);
        let mut sum = 0.0;
        for (m, slope) in slopes.iter_mut().enumerate() {
            let m = m as f64;
            *slope *=
                alpha * (sum - m / alpha - logarithm + (alpha + m) * s / (alpha * alpha * base));
            sum += 1.0 / (alpha + m);
        }
    }
}

impl<const D: usize> Kernel<D> for RationalQuadratic {
    fn name(&self) -> String {
        "rational-quadratic".into()
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        let mut all = lengthscales(self.axes.of::<D>());
        all.push(Hyperparameter {
            name: "shape",
            measure: Measure::Number { lower: 0.1, upper: 100.0 },
        });
        all
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        Box::new(Self { axes: self.axes.among::<D>(axes) })
    }

    fn formula(&self, parameters: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        let alpha = &parameters[self.axes.of::<D>().len()];
        let s = half_square(self.axes.of::<D>(), parameters, x, y);
        ((s / alpha + 1.0).ln() * alpha * -1.0).exp()
    }

    fn is_stationary(&self) -> bool {
        true
    }

    fn derivatives(
        &self,
        parameters: &[f64],
        pairs: &Pairs<'_, D>,
        orders: &[Orders<D>],
        table: &mut [f64],
    ) {
        let profile = PowerLaw { alpha: parameters[self.axes.of::<D>().len()] };
        radial::derivatives(&profile, self.axes.of::<D>(), parameters, pairs, orders, table);
    }

    fn pull_back(
        &self,
        parameters: &[f64],
        pairs: &Pairs<'_, D>,
        orders: &[Orders<D>],
        weights: &[f64],
        gradient: &mut [f64],
    ) {
        let alpha = parameters[self.axes.of::<D>().len()];
        let profile = PowerLaw { alpha };
        radial::pull_back(
            &profile,
            self.axes.of::<D>(),
            parameters,
            pairs,
            orders,
            weights,
            gradient,
        );
        let mut table = vec![0.0; weights.len()];
        let by_shape = ByShape { alpha };
        radial::derivatives(&by_shape, self.axes.of::<D>(), parameters, pairs, orders, &mut table);
        gradient[self.axes.of::<D>().len()] +=
            table.iter().zip(weights).map(|(t, w)| t * w).sum::<f64>();
    }
}
