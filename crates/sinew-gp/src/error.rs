//! Errors in a problem, its data, or a fit.

use thiserror::Error;

/// Errors of this crate. Texts say what is wrong, where, and what to do.
#[derive(Clone, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum GpError {
    /// A domain, equation, condition, kernel, observation or request that is contradictory, singular or not supported.
    #[error("{0}")]
    Invalid(String),
    /// A covariance matrix that stays indefinite.
    #[error(
        "the covariance of {size} observations is not positive definite even with a relative jitter of {jitter:e}; remove duplicate noise-free points or add noise"
    )]
    NotPositiveDefinite { size: usize, jitter: f64 },
    /// An equation so far off between its points that no interval can be given.
    #[error(
        "no interval: between its points the equation is off by {residual:.1e} where its terms are of the size {term:.1e}, worst at {}; add points there, stretch the axis by `Prior::stretched` where the solution or a condition is steep, or raise `FitOptions::most_points`",
        place(at)
    )]
    Unresolved { at: Vec<f64>, residual: f64, term: f64 },
    /// Matrices of all observations that do not fit into memory.
    #[error(
        "a fit to {observations} observations takes matrices of {gigabytes:.1} GB, more than the {most:.1} GB of `FitOptions::most_memory`; average values over cells by `Data::averaged`"
    )]
    TooLarge { observations: usize, gigabytes: f64, most: f64 },
}

/// Leaves with [`GpError::Invalid`] and a text in the manner of `format!` unless a condition holds.
macro_rules! ensure {
    ($holds:expr, $($text:tt)+) => {
        match $holds {
            true => {}
            false => return Err($crate::GpError::Invalid(format!($($text)+))),
        }
    };
}

/// Result with an error of this crate.
pub(crate) type Result<T, E = GpError> = std::result::Result<T, E>;

/// Coordinates, for messages.
pub(crate) fn place(coordinates: &[f64]) -> String {
    let numbers: Vec<String> = coordinates.iter().map(f64::to_string).collect();
    format!("({})", numbers.join(", "))
}

/// Requires equal numbers of both.
pub(crate) fn check_lengths(points: usize, values: usize) -> Result<()> {
    ensure!(points == values, "{points} points but {values} values; give one value for each point");
    Ok(())
}
