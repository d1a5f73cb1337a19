//! Errors of recipes that train networks.

/// Result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Errors of recipes that train networks.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Simulations, settings, folders or observers, as in every recipe.
    #[error(transparent)]
    Emulate(#[from] sinew_emulate::Error),
    /// A network that cannot be made, trained or asked.
    #[error(transparent)]
    Network(#[from] sinew_gnn::Error),
    /// Coordinates or scales that do not suit a body.
    #[error(transparent)]
    Coordinates(#[from] sinew_coordinates::CoordinateError),
    /// A mesh that has no valid graph.
    #[error("the mesh could not be turned into a graph: {0}")]
    Graph(#[from] sinew_graph::GraphError),
    /// A solve on the way.
    #[error(transparent)]
    Solve(#[from] sinew_fem::SolveError),
}

impl From<Error> for sinew_emulate::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Emulate(error) => error,
            Error::Solve(error) => error.into(),
            other => Self::Network(Box::new(other)),
        }
    }
}
