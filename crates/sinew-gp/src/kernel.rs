//! Covariance functions, with the derivatives that operators take of them.

mod check;
mod formula;
mod shapes;
pub(crate) mod table;

pub use check::check_kernel;
pub use formula::Formula;
pub use shapes::{Smoothness, linear, matern, periodic, rational_quadratic, squared_exponential};
pub(crate) use table::Hermites;

/// Kind of a hyperparameter, from which its bounds and restarts follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// A length along an axis, bounded relative to the axis' extent.
    Length {
        /// The axis.
        axis: usize,
    },
    /// A positive number without unit that a kernel has along one axis only, within these bounds.
    Width {
        /// The axis.
        axis: usize,
        /// Lower bound, positive.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A positive number without unit, within these bounds.
    Number {
        /// Lower bound, positive.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
}

/// A positive number that a kernel depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct Hyperparameter {
    /// Name, as `lengthscale`.
    pub name: &'static str,
    /// Kind.
    pub measure: Measure,
}

/// Derivative to be taken of k(x, x′): order along each axis in x, and in x′. In tables of a stationary kernel the second is
/// zero, see [`Formula::entry`].
pub(crate) type Orders<const D: usize> = [[usize; D]; 2];

/// Derivatives that are asked for, at which hyperparameters, and of which pairs: many first points
/// with one second point.
pub(crate) struct Request<'a, const D: usize> {
    /// The kernel.
    pub kernel: &'a Formula<D>,
    /// Values of the hyperparameters.
    pub hyperparameters: &'a [f64],
    /// Coordinates x of the first points, axis by axis.
    pub first: [&'a [f64]; D],
    /// The second point x′.
    pub second: [f64; D],
    /// The derivatives.
    pub orders: &'a [Orders<D>],
}

impl<const D: usize> Request<'_, D> {
    /// Number of pairs.
    pub(crate) fn count(&self) -> usize {
        self.first[0].len()
    }

    /// Highest order of a derivative in x along an axis.
    pub(crate) fn most(&self, axis: usize) -> usize {
        self.orders.iter().map(|order| order[0][axis]).max().unwrap_or(0)
    }
}

/// Most pairs in one request: they stay in the fastest cache.
pub(crate) const MOST_PAIRS: usize = 64;
