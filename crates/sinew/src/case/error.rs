//! Errors of a case file: what is wrong, where, and what to do.

use std::path::PathBuf;

/// Why a case file describes no body.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CaseError {
    /// A file that cannot be read.
    #[error("the case file {} cannot be read: {source}{advice}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
        /// A name that may have been meant.
        advice: String,
    },
    /// Something wrong at a key.
    #[error("{file}{}{}: {reason}", place(*line), named(key))]
    Key {
        /// The case file.
        file: String,
        /// Line, from 1.
        line: Option<usize>,
        /// The key with those of the tables around it, such as `parameters.mu`.
        key: String,
        /// Fault and advice.
        reason: String,
    },
}

fn place(line: Option<usize>) -> String {
    line.map_or(String::new(), |line| format!(", line {line}"))
}

fn named(key: &str) -> String {
    if key.is_empty() { String::new() } else { format!(", {key}") }
}
