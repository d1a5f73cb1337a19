//! A periodic kernel along one axis.

use super::{Hyperparameter, Kernel, Measure};
use crate::error::GpError;
use crate::series::Series;
use std::f64::consts::PI;

/// exp(−2 sin²(π (x − x′) / period) / w²): the squared exponential of a point's position on a
/// circle (MacKay 1998; the thesis warps inputs likewise). The width w is in units of the circle's radius.
#[derive(Clone, Debug)]
pub struct Periodic {
    axis: usize,
    period: f64,
    /// False once restricted to axes without its own.
    active: bool,
}

impl Periodic {
    /// Along `axis`, with the period `period`.
    ///
    /// # Errors
    /// If the period is not finite and above 0.
    pub fn new(axis: usize, period: f64) -> Result<Self, GpError> {
        match period.is_finite() && period > 0.0 {
            true => Ok(Self { axis, period, active: true }),
            false => Err(GpError::Kernel(format!(
                "a periodic kernel of period {period}; give a finite one above 0"
            ))),
        }
    }
}

impl<const D: usize> Kernel<D> for Periodic {
    fn name(&self) -> String {
        "periodic".into()
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        let width =
            Hyperparameter { name: "width", measure: Measure::Number { lower: 0.1, upper: 30.0 } };
        if self.active { vec![width] } else { Vec::new() }
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        Box::new(Self { active: self.active && axes.contains(&self.axis), ..self.clone() })
    }

    fn formula(&self, width: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        match width.first() {
            None => x[0].constant(1.0),
            Some(width) => {
                let angle = (&x[self.axis] - &y[self.axis]) * (PI / self.period);
                ((angle.sin() / width).squared() * -2.0).exp()
            }
        }
    }

    fn is_stationary(&self) -> bool {
        true
    }
}
