//! Errors, with the numbers and what to try.

use sinew_emulate::coordinates::CoordinateError;
use std::path::PathBuf;

/// Errors of emulators, data sets and training.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// A configuration value admits no network.
    #[error("emulator configuration: {what} is {value}, but must be at least 1")]
    Configuration { what: &'static str, value: usize },
    /// The share of the budget that trains the node embeddings is not between 0 and 1.
    #[error(
        "the share of the budget that trains the node embeddings is {0}; give a number from 0 to 1"
    )]
    EmbeddingShare(f64),
    /// A sample names a geometry the set does not have.
    #[error(
        "sample {sample} belongs to geometry {geometry}, but there are only {geometries} geometries"
    )]
    UnknownGeometry { sample: usize, geometry: usize, geometries: usize },
    /// Training without samples, or on a device that records no gradients.
    #[error("nothing to train on: {0}")]
    NothingToTrain(&'static str),
    /// A loss or gradient that is not finite.
    #[error(
        "training diverged at step {step}: loss {loss}, gradient norm {gradient_norm}, learning rate {learning_rate:.3e}; \
         take another seed, narrow the ranges of the parameters, or choose another recipe"
    )]
    Diverged { step: usize, loss: f64, gradient_norm: f64, learning_rate: f64 },
    /// A prediction with infinite potential energy.
    #[error(
        "at step {step} of the training {inadmissible} of {samples} predictions invert a cell, and their energy is not \
         finite; train on a potential with barriers (Body::with_barriers), or begin from a displacement that \
         inverts no cell"
    )]
    InvertedCells { step: usize, inadmissible: usize, samples: usize },
    /// A prediction that is not finite.
    #[error(
        "the prediction for parameter set {sample} is not finite; the parameters are far outside the trained range or the weights are damaged"
    )]
    PredictionNotFinite { sample: usize },
    /// A backend this build does not contain.
    #[error("this build has no `{0}` backend; build it with --features {0}")]
    MissingBackend(&'static str),
    /// A backend without a device.
    #[error(
        "this machine has no device for the backend `{0}`, or no driver of it; use another backend, such as flex"
    )]
    NoDevice(&'static str),
    /// A sample at which the potential cannot be evaluated.
    #[error("sample {sample} does not suit the potential: {reason}")]
    Parameters { sample: usize, reason: String },
    /// Coordinates or scales that do not suit a body or a sample.
    #[error(transparent)]
    Coordinates(#[from] CoordinateError),
    /// Features do not fit the graph.
    #[error(transparent)]
    Graph(#[from] sinew_graph::GraphError),
    /// A mesh that has no valid graph.
    #[error("the mesh could not be turned into a graph: {0}")]
    Mesh(sinew_graph::GraphError),
    /// Simulations, settings, folders or observers, as in every recipe.
    #[error(transparent)]
    Emulate(#[from] sinew_emulate::Error),
    /// A solve in the course of training.
    #[error(transparent)]
    Solve(#[from] sinew_fem::SolveError),
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    /// A file does not hold what was expected.
    #[error("{}: {reason}", path.display())]
    Format { path: PathBuf, reason: String },
    /// A directory was written by another format version.
    #[error("{}: format version {found}, this build reads version {expected}; train again or use the build that wrote it", path.display())]
    Version { path: PathBuf, found: u32, expected: u32 },
}

/// Result with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl From<Error> for sinew_emulate::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Emulate(error) => error,
            Error::Solve(error) => error.into(),
            other => Self::Network(Box::new(other)),
        }
    }
}
