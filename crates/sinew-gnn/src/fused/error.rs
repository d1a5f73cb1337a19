//! Errors in the indices handed to a fused operation.

use thiserror::Error;

/// An index set that cannot be used.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum IndexError {
    /// An edge or a row refers to a target that does not exist.
    #[error("entry {position} refers to {index}, but there are only {count}; indices start at 0")]
    OutOfRange { position: usize, index: usize, count: usize },
    /// Senders and receivers of edges differ in number.
    #[error("{senders} senders but {receivers} receivers; give one of each per edge")]
    UnpairedEdges { senders: usize, receivers: usize },
    /// More entries than 32-bit indices can number.
    #[error("{0} entries do not fit 32-bit indices")]
    TooMany(usize),
}
