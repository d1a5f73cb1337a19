//! The linear kernel.

use super::axes::Axes;
use super::radial::lengths;
use super::{Hyperparameter, Kernel};
use crate::series::Series;

/// 1 + Σ xᵢ xᵢ′ / λᵢ²: affine functions (1.26).
#[derive(Clone, Debug, Default)]
pub struct Linear {
    axes: Axes,
}

impl Linear {
    /// On all axes.
    pub fn new() -> Self {
        Self::default()
    }

    /// On the axes with these numbers only.
    pub fn along(axes: &[usize]) -> Self {
        Self { axes: Axes::only(axes) }
    }
}

impl<const D: usize> Kernel<D> for Linear {
    fn name(&self) -> String {
        "linear".into()
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        lengths("length", self.axes.of::<D>())
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        Box::new(Self { axes: self.axes.among::<D>(axes) })
    }

    fn formula(&self, lengths: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        self.axes.of::<D>().iter().zip(lengths).fold(x[0].constant(1.0), |sum, (d, length)| {
            sum + (&x[*d] / length) * (&y[*d] / length)
        })
    }
}
