//! Errors in a report.

use std::path::{Path, PathBuf};

/// Why a report, one of its parts or one of its files was refused.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ReportError {
    /// An error, a time or a position is NaN, infinite or, the first two, negative.
    #[error(
        "{0} is {1}, but it must be finite, and errors and times not negative; measure it, or leave the \
         method out of the report and say so in a note"
    )]
    Number(String, f64),
    /// A row lacks its error or its time, or there are no samples to summarise.
    #[error("{0} is missing; evaluate and time the method on at least one case")]
    Missing(String),
    /// A list has other entries than what it belongs to.
    #[error("{0}: {1} entries, expected {2}")]
    Length(String, usize, usize),
    /// A triangle names a node that does not exist.
    #[error("triangle {0} names node {1}, but there are only {2} nodes")]
    Triangle(usize, usize, usize),
    /// The file was written with another version of the schema.
    #[error(
        "the report has schema {0}, this program reads schema {1}; run the study again or use the version \
         that wrote the file"
    )]
    Schema(u64, u32),
    /// The text is not a report.
    #[error("not a report: {0}")]
    Json(#[from] serde_json::Error),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io { path: PathBuf, source: std::io::Error },
}

impl ReportError {
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, source }
    }
}
