//! Errors of an augmented graph and its features.

/// Why a graph could not be built, read or described: what is wrong, where, with the number, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct GraphError(pub(crate) String);

/// Leaves with a [`GraphError`] and a text in the manner of `format!` unless a condition holds.
macro_rules! ensure {
    ($holds:expr, $($text:tt)+) => {
        match $holds {
            true => {}
            false => return Err($crate::GraphError(format!($($text)+))),
        }
    };
}
