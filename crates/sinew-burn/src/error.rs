//! What can be wrong with the indices handed to a fused operation.

use thiserror::Error;

/// An index set that cannot be used.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum IndexError {
    /// An edge or a row refers to a target that does not exist.
    #[error("entry {position} refers to {index}, but there are only {count}; indices start at 0")]
    OutOfRange {
        /// Position of the entry in its list.
        position: usize,
        /// The offending index.
        index: usize,
        /// Number of targets.
        count: usize,
    },
    /// Senders and receivers of edges differ in number.
    #[error("{senders} senders but {receivers} receivers; give one of each per edge")]
    UnpairedEdges {
        /// Length of the list of senders.
        senders: usize,
        /// Length of the list of receivers.
        receivers: usize,
    },
    /// Sources of one plan cover different numbers of rows.
    #[error("source {source_number} covers {found} rows, the plan has {expected}")]
    RowCount {
        /// Which source of the plan.
        source_number: usize,
        /// Rows that it covers.
        found: usize,
        /// Rows of the plan.
        expected: usize,
    },
    /// More sources than a fused operation is compiled for.
    #[error("{found} sources; a plan takes 1 to {most}")]
    SourceCount {
        /// Sources of the plan.
        found: usize,
        /// Largest number.
        most: usize,
    },
    /// More entries than 32-bit indices can number.
    #[error("{0} entries do not fit 32-bit indices")]
    TooMany(usize),
}
