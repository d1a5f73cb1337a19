//! What can be wrong with a report.

use std::path::{Path, PathBuf};

/// Why a report, one of its rows or one of its files was refused.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A required number is NaN, infinite or negative.
    #[error(
        "{field} is {value}, but numbers must be finite, and errors and times not negative; \
         measure it, or leave the method out of the report"
    )]
    Number {
        /// Path of the field, e.g. `dd.times.train_s`.
        field: String,
        /// The offending value.
        value: f64,
    },
    /// A sample from which errors are summarised is NaN, infinite or negative.
    #[error(
        "{field}: sample {index} is {value}, but errors must be finite and not negative; \
         an inverted element has infinite energy, so evaluate such a prediction with the \
         guarded energy or report the method as failed"
    )]
    Sample {
        /// Field the sample belongs to, e.g. `err_u_mm`.
        field: &'static str,
        /// Position in the samples as they were given.
        index: usize,
        /// The offending value.
        value: f64,
    },
    /// No samples to summarise.
    #[error("{field} has no samples; evaluate the method on at least one test case")]
    NoSamples {
        /// Field without samples, e.g. `err_F_pct`.
        field: &'static str,
    },
    /// A required text is empty.
    #[error("{field} is empty; say in one line what the reader should know")]
    EmptyText {
        /// Path of the field, e.g. `dd.description`.
        field: String,
    },
    /// Two lists that belong together differ in length.
    #[error("{what} has {found} entries, expected {expected}")]
    Length {
        /// The list, e.g. `deformed`.
        what: String,
        /// Its length.
        found: usize,
        /// The length of the list it belongs to.
        expected: usize,
    },
    /// A triangle names a node that does not exist.
    #[error("triangle {triangle} names node {node}, but there are only {nodes} nodes")]
    TriangleNode {
        /// Index of the triangle.
        triangle: usize,
        /// Node it names.
        node: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// The file was written with another version of the schema.
    #[error(
        "report has schema {found}, this program reads schema {expected}; \
         run the study again or use the program version that wrote the file"
    )]
    Schema {
        /// Number in the file.
        found: u64,
        /// Number this program reads.
        expected: u32,
    },
    /// The text is no report.
    #[error("not a report: {0}")]
    Json(#[from] serde_json::Error),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
}

impl ReportError {
    pub(crate) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }
}

/// Accepts a finite number that is not negative; the error names `field`.
pub(super) fn check_number(field: impl FnOnce() -> String, value: f64) -> Result<(), ReportError> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    Err(ReportError::Number { field: field(), value })
}
