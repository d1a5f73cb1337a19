//! Errors in meshes and files, with places and advice.

use std::{fmt, io, path::PathBuf};
use thiserror::Error;

/// A mesh or a file that cannot be used.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum MeshError {
    /// The operating system refused to open, read or write the file.
    #[error("{}: {source}; check the path and the permissions", path.display())]
    File { path: PathBuf, source: io::Error },
    /// The file's content is not a mesh that can be read.
    #[error("{file}, {place}: {problem}")]
    Content { file: String, place: Place, problem: Refusal },
    /// Cells in memory that cannot form a mesh, or a mesh that violates a rule of [`crate::Mesh::check`].
    #[error(transparent)]
    Refused(#[from] Refusal),
}

impl MeshError {
    pub(crate) fn in_file(file: &str, (place, problem): (Place, Refusal)) -> Self {
        Self::Content { file: file.into(), place, problem }
    }
}

/// A place in a file: the line in text, the byte everywhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Offset from the start of the file, in bytes.
    pub byte: usize,
    /// Line number from 1, in text.
    pub line: Option<usize>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line} (byte {})", self.byte),
            None => write!(f, "byte {}", self.byte),
        }
    }
}

/// Why something cannot be read, selected or made, with names, numbers and places in the unit of the mesh, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct Refusal(pub String);

impl From<quick_xml::Error> for Refusal {
    fn from(error: quick_xml::Error) -> Self {
        Self(format!("not well-formed XML ({error}); export the file again"))
    }
}
