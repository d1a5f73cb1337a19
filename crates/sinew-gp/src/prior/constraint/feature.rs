//! A summand of a constrained kernel.

use crate::prior::structure::Factor;
use crate::problem::field::{Field, field};
use crate::series::Series;

/// A summand φ(x) φ(x′) k(x, x′) of a constrained kernel.
#[derive(Clone, Debug)]
pub struct Feature<const D: usize> {
    /// The factor φ, of size one.
    pub factor: Field<D>,
    /// The axes that k depends on; none for a constant that is integrated out (4.54).
    pub axes: Vec<usize>,
}

impl<const D: usize> Feature<D> {
    /// Feature with a kernel on all axes.
    pub(super) fn everywhere(factor: Field<D>) -> Self {
        Self { factor, axes: (0..D).collect() }
    }

    /// Feature with one more factor.
    pub(super) fn times(&self, axis: usize, own: &Factor<D>) -> Self {
        let axes = self.axes.iter().copied().filter(|d| *d != axis || own.free).collect();
        let factor = match (self.factor.clone(), own.field.clone()) {
            (before, None) => before,
            (before, Some(own)) => field(move |x: [Series; D]| before.at(x.clone()) * own.at(x)),
        };
        Self { factor, axes }
    }
}
