//! A summand of a constrained kernel.

use crate::field::{Field, field};
use crate::kernel::Kernel;
use crate::series::Series;
use crate::structure::Factor;

/// A summand φ(x) φ(x′) k(x, x′) of a constrained kernel.
#[derive(Clone, Debug)]
pub struct Feature<const D: usize> {
    /// The factor φ, of size one.
    pub factor: Field<D>,
    /// The axes that k depends on; none for a constant that is integrated out (4.54).
    pub axes: Vec<usize>,
    /// The direction in the plane of the first two axes that alone k depends on there: for traces
    /// on an edge of a polygon, along it. k then takes the position along it as its first coordinate.
    pub direction: Option<[f64; 2]>,
}

impl<const D: usize> Feature<D> {
    /// Feature with a kernel on all axes.
    pub(super) fn everywhere(factor: Field<D>) -> Self {
        Self { factor, axes: (0..D).collect(), direction: None }
    }

    /// Feature with a kernel on the axes behind the plane of a polygon.
    pub(super) fn beyond_plane(factor: Field<D>) -> Self {
        Self { factor, axes: (2..D).collect(), direction: None }
    }

    /// Feature with one more factor.
    pub(super) fn times(&self, axis: usize, own: &Factor<D>) -> Self {
        let axes = self.axes.iter().copied().filter(|d| *d != axis || own.free).collect();
        let factor = match (self.factor.clone(), own.field.clone()) {
            (before, None) => before,
            (before, Some(own)) => field(move |x: [Series; D]| before.at(x.clone()) * own.at(x)),
        };
        Self { factor, axes, direction: self.direction }
    }

    /// `kernel` as a function of what k depends on.
    pub fn kernel(&self, kernel: &dyn Kernel<D>) -> Box<dyn Kernel<D>> {
        let across = |axis: &usize| *axis == 1 && self.direction.is_some();
        let axes: Vec<usize> = self.axes.iter().copied().filter(|axis| !across(axis)).collect();
        kernel.on_axes(&axes)
    }
}
