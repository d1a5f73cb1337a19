//! Errors of fibre rules, with numbers and advice.

use sinew_energy::listed;
use sinew_mesh::Defect;
use thiserror::Error;

/// A result whose error is that of fibres.
pub(super) type Result<T, E = FibreError> = std::result::Result<T, E>;

/// A wall or a rule that gives no fibres.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum FibreError {
    /// The mesh breaks a rule of every mesh.
    #[error(transparent)]
    Mesh(#[from] Defect),
    /// No facet set has this name.
    #[error("the mesh has no facet set `{name}`; it has {}", listed(known))]
    UnknownSurface { name: String, known: Vec<String> },
    /// A surface without facets.
    #[error("the facet set `{name}` is empty; put the facets of that surface into it")]
    EmptySurface { name: String },
    /// A point that is farther from the wall than this fraction of its thickness.
    #[error(
        "({}, {}, {}) is farther from the wall than {slack:.2e} of its thickness; \
         allow more slack where facets cut corners",
        point[0], point[1], point[2]
    )]
    Outside { point: [f64; 3], slack: f64 },
    /// A mesh, an angle or an ellipsoid that a rule has no fibres for.
    #[error("{0}")]
    Unfit(String),
}
