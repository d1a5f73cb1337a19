//! Covariance functions, with the derivatives that operators take of them.

mod axes;
mod check;
mod combined;
mod linear;
mod matern;
mod periodic;
mod radial;
mod rational_quadratic;
mod scaled;
mod squared_exponential;
mod table;

use crate::series::Series;
use std::fmt::Debug;

pub use check::check_kernel;
pub(crate) use check::unusable;
pub use combined::{Product, Sum};
pub use linear::Linear;
pub use matern::{Matern, Smoothness};
pub use periodic::Periodic;
pub use rational_quadratic::RationalQuadratic;
pub use scaled::Scaled;
pub use squared_exponential::SquaredExponential;

use table::{from_formula, pull_back_from_formula};

/// Kind of a hyperparameter, from which its bounds and restarts follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// A length along an axis, bounded relative to the axis' extent.
    Length {
        /// The axis.
        axis: usize,
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

/// Derivatives to be taken of k(x, x′): in the first and in the second argument, for each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orders<const D: usize> {
    /// Orders in x.
    pub first: [usize; D],
    /// Orders in x′; all zero when asking a stationary kernel, where −∂/∂x takes their place.
    pub second: [usize; D],
}

impl<const D: usize> Orders<D> {
    /// Total order in each axis.
    pub(crate) fn sums(&self) -> [usize; D] {
        std::array::from_fn(|d| self.first[d] + self.second[d])
    }
}

/// Which derivatives are asked for, at which hyperparameters, and of which pairs: many first points
/// with one second point.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a, const D: usize> {
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
    pub fn count(&self) -> usize {
        self.first[0].len()
    }

    /// First point of pair `lane`.
    pub fn point(&self, lane: usize) -> [f64; D] {
        self.first.map(|axis| axis[lane])
    }
}

/// Most pairs in one call of [`Kernel::derivatives`]: they stay in the fastest cache.
pub const MOST_PAIRS: usize = 64;

/// A covariance function of variance one (unless scaled), with positive hyperparameters.
///
/// Only [`Kernel::formula`] and a few facts must be given: derivatives then come from Taylor
/// series, pair by pair. Most kernels of this crate give theirs in closed form, which is faster by far.
/// Test yours with [`check_kernel`].
///
/// ```
/// use sinew_gp::{Hyperparameter, Kernel, Measure, check_kernel};
/// use sinew_gp::Series;
///
/// /// (1 + x² x′²): functions of the form a + b x² along the first axis.
/// #[derive(Clone, Debug)]
/// struct Even;
///
/// impl<const D: usize> Kernel<D> for Even {
///     fn name(&self) -> String {
///         "even quadratic".into()
///     }
///     fn hyperparameters(&self) -> Vec<Hyperparameter> {
///         Vec::new()
///     }
///     fn on_axes(&self, _: &[usize]) -> Box<dyn Kernel<D>> {
///         Box::new(Even)
///     }
///     fn formula(&self, _: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
///         x[0].squared() * y[0].squared() + 1.0
///     }
/// }
///
/// check_kernel::<2>(&Even, &[], [0.0, 0.0], [1.0, 1.0], 7)?;
/// # Ok::<(), sinew_gp::GpError>(())
/// ```
pub trait Kernel<const D: usize>: Debug + Send + Sync {
    /// Its name, for messages.
    fn name(&self) -> String;

    /// The hyperparameters, in the order in which their values are handed over.
    fn hyperparameters(&self) -> Vec<Hyperparameter>;

    /// Kernel as a function of these axes only.
    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>>;

    /// k(x, x′) over Taylor series, at positive `hyperparameters`.
    fn formula(&self, hyperparameters: &[Series], x: &[Series; D], y: &[Series; D]) -> Series;

    /// How many derivatives its functions have in the mean-square sense; none for all.
    fn smoothness(&self) -> Option<usize> {
        None
    }

    /// Whether it depends on x − x′ only; then derivatives in x suffice.
    fn is_stationary(&self) -> bool {
        false
    }

    /// Derivatives of k for each pair: entry `e` of the request's orders fills `table[e · count ..]`.
    ///
    /// At most [`MOST_PAIRS`] pairs are asked for at once.
    fn derivatives(&self, request: &Request<'_, D>, table: &mut [f64]) {
        from_formula(self, request, table);
    }

    /// Adds to `gradient` the derivatives of Σ weight · table with respect to the logarithm of
    /// each hyperparameter, for `weights` in the layout of the table of [`Kernel::derivatives`].
    fn pull_back(&self, request: &Request<'_, D>, weights: &[f64], gradient: &mut [f64]) {
        pull_back_from_formula(self, request, weights, gradient);
    }

    /// [`Kernel::derivatives`] into `table`, then [`Kernel::pull_back`] for the weights that
    /// `weigh` makes of it, in memory of the same size; a kernel may share work between the two.
    fn derivatives_and_pull_back(
        &self,
        request: &Request<'_, D>,
        [table, weights]: [&mut [f64]; 2],
        weigh: &mut dyn FnMut(&[f64], &mut [f64]),
        gradient: &mut [f64],
    ) {
        self.derivatives(request, table);
        weigh(table, weights);
        self.pull_back(request, weights, gradient);
    }
}
