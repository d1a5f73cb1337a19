//! What can be wrong with a kernel.

use thiserror::Error;

/// A property that a kernel lacks.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum KernelFault {
    /// The number of values does not match [`crate::Kernel::hyperparameters`].
    #[error("{found} hyperparameter values for a kernel that names {expected}")]
    Hyperparameters {
        /// Values given.
        found: usize,
        /// Names declared.
        expected: usize,
    },
    /// A hyperparameter that cannot be adjusted, or a value that it cannot have.
    #[error("hyperparameter {number} ({name}): {problem}")]
    Declaration {
        /// Which hyperparameter.
        number: usize,
        /// Its name.
        name: &'static str,
        /// What is wrong and what to do.
        problem: &'static str,
    },
    /// k(x, x′) ≠ k(x′, x).
    #[error("not symmetric: k(x, x') = {forward}, k(x', x) = {backward}")]
    Symmetry {
        /// k(x, x′).
        forward: f64,
        /// k(x′, x).
        backward: f64,
    },
    /// A value that is no number.
    #[error("k(x, x') = {value} at x = {first:?}, x' = {second:?}")]
    NotFinite {
        /// The value.
        value: f64,
        /// x.
        first: Vec<f64>,
        /// x′.
        second: Vec<f64>,
    },
    /// A covariance matrix with a negative eigenvalue, beyond what rounding makes of zero.
    #[error(
        "the covariance of {points} points has the eigenvalue {eigenvalue:e} in units of the variance"
    )]
    Definiteness {
        /// Number of points.
        points: usize,
        /// Its smallest eigenvalue.
        eigenvalue: f64,
    },
    /// Derivatives that do not belong to the formula.
    #[error("derivative {orders}: {given} in the table, {expected} by {method}")]
    Derivative {
        /// Which derivative, in words.
        orders: String,
        /// In the kernel's table.
        given: f64,
        /// As it should be.
        expected: f64,
        /// How that was found.
        method: &'static str,
    },
    /// A gradient that does not belong to the table.
    #[error("gradient in hyperparameter {number}: {given}, by differences {expected}")]
    Gradient {
        /// Which hyperparameter.
        number: usize,
        /// As given.
        given: f64,
        /// As it should be.
        expected: f64,
    },
}
