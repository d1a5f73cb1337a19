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
    Content { file: String, place: Place, problem: Box<Problem> },
    /// Cells in memory that cannot form a mesh.
    #[error(transparent)]
    Cells(Box<Problem>),
    /// A mesh in memory violates a rule of [`crate::Mesh::check`].
    #[error(transparent)]
    Defect(#[from] Defect),
}

impl MeshError {
    pub(crate) fn in_file(file: &str, (place, problem): (Place, Problem)) -> Self {
        Self::Content { file: file.into(), place, problem: Box::new(problem) }
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

/// Fault in a file's content.
#[derive(Debug, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Problem {
    /// An unknown format.
    #[error(
        "this is neither legacy VTK, VTU, VTP, gmsh MSH, Abaqus or CalculiX input (.inp), STL nor CARP (.pts with .elem); \
         convert the mesh to one of them, for example with `meshio convert`"
    )]
    UnknownFormat,
    /// Something else was expected.
    #[error("expected {expected}, found `{}`; correct it or export the file again", found.escape_debug())]
    Expected { expected: &'static str, found: String },
    /// A required part is missing.
    #[error("expected {expected}, which is missing; export the file again with it")]
    Missing { expected: &'static str },
    /// The file ends before the numbers it declares.
    #[error(
        "{what}: only {available} of {needed} bytes are left in the file; the declared count is wrong or \
         the file was cut off: export or copy it again"
    )]
    CutOff { what: &'static str, needed: u128, available: usize },
    /// A count disagrees with another one.
    #[error("{what}: expected {expected} of them, found {found}; export the file again")]
    Count { what: String, expected: usize, found: usize },
    /// An integer out of range.
    #[error("{what} is {value}, which is outside {least}..={most}; export the file again")]
    Range { what: &'static str, value: i64, least: i64, most: i64 },
    /// A correct file of a kind that this crate does not read.
    #[error("{what} `{}` cannot be read; {advice}", value.escape_debug())]
    Unsupported { what: &'static str, value: String, advice: &'static str },
    /// A cell of another kind than the mesh has.
    #[error("cell {cell} is a {kind}, but the mesh wants {wanted}; {advice}")]
    Cell { cell: usize, kind: &'static str, wanted: &'static str, advice: &'static str },
    /// A zlib block that does not give the bytes it declares, or text that is not base64.
    #[error("{what}; the file is damaged: export or copy it again")]
    Damaged { what: String },
    /// Text that is no XML.
    #[error("not well-formed XML ({0}); export the file again")]
    Xml(#[from] quick_xml::Error),
    /// A file with a mesh that violates a rule.
    #[error(transparent)]
    Defect(#[from] Defect),
}

/// Violation of a rule of meshes.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Defect {
    /// A cell names a node that does not exist.
    #[error("cell {cell} names node {node}, but nodes run from 0 to {} (nodes: {nodes}); renumber its nodes", nodes.saturating_sub(1))]
    NodeOutOfRange { cell: usize, node: i64, nodes: usize },
    /// A cell names a node twice.
    #[error(
        "cell {cell} names node {node} twice; mesh it by cells without repeated nodes, such as tetrahedra"
    )]
    RepeatedNode { cell: usize, node: usize },
    /// A curved cell or a hexahedron that is folded over at one of its nodes; the Jacobian is its volume (area) over that of the
    /// reference cell.
    #[error(
        "cell {cell} is folded over at its node {node}: its Jacobian there is {jacobian:e}, but must be \
         positive; move the node, or number the cell in the order of VTK"
    )]
    Folded { cell: usize, node: usize, jacobian: f64 },
    /// A coordinate that is not finite.
    #[error("node {node} lies at ({}); give it finite coordinates", point.map(|x| x.to_string()).join(", "))]
    NotFinite { node: usize, point: [f64; 3] },
    /// A mesh without cells.
    #[error("the mesh has no {wanted}; export the file with its cells")]
    NoCells { wanted: &'static str },
    /// A field that does not have one row per node or cell.
    #[error(
        "field `{}` holds {values} numbers, but {rows} rows of {components} components are needed; resize it",
        field.escape_debug()
    )]
    FieldSize { field: String, values: usize, rows: usize, components: usize },
    /// A field that marks nodes by what is not a number.
    #[error("field `{}` is {value} at node {row}; give it a finite number, 0 where it marks nothing", field.escape_debug())]
    FieldNotFinite { field: String, row: usize, value: f64 },
    /// A set names a node, cell or facet that does not exist.
    #[error("set `{}` names index {index}, but there are only {limit}; remove it from the set", set.escape_debug())]
    SetMember { set: String, index: usize, limit: usize },
    /// A field asked for by name does not exist or is of another kind.
    #[error("there is no {wanted} field `{}`, only: {}; choose one of these", field.escape_debug(), available.join(", "))]
    NoSuchField { field: String, wanted: &'static str, available: Vec<String> },
    /// A name that files cannot hold or that is taken for the encoding of sets.
    #[error(
        "name `{}` cannot be written; use a non-empty name without control characters that \
         does not start with `node_set:`, `facet_set:` or `cell_set:`",
        name.escape_debug()
    )]
    Name { name: String },
}

/// Why something cannot be selected or made, with names, numbers and places in the unit of the mesh, and what to do.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct Refusal(pub(crate) String);

impl From<Defect> for Refusal {
    fn from(defect: Defect) -> Self {
        Self(defect.to_string())
    }
}
