//! All states of a patient at one θ.

use crate::observable::ForwardError;
use sinew_energy::{Body, ThetaError};
use sinew_fem::{Solution, SolveError, UnloadError, Unloaded};
use thiserror::Error;

/// The unloaded body and its phases at one θ.
#[derive(Debug)]
pub struct PatientStates {
    /// The body at rest.
    pub rest: Body,
    /// Unloading that found it; `None` where the image is at rest.
    pub unloaded: Option<Unloaded>,
    /// The equilibria of the phases; displacements are counted from rest \[length\].
    pub phases: Vec<Solution>,
    /// Displacements from the image, `3 × nodes` \[length\], of the image, the body at rest and the phases.
    pub moved: Vec<Vec<f64>>,
    /// Derivatives of these in each parameter, if asked for: by state, then by parameter.
    pub slopes: Vec<Vec<Vec<f64>>>,
}

/// A θ at which a patient has no states.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum StateError {
    /// θ of another length.
    #[error("theta has {given} entries for {needed} parameters")]
    Length { given: usize, needed: usize },
    /// θ that makes no sense in a state.
    #[error("at {state}: {source}")]
    Theta { state: String, source: ThetaError },
    /// No body at rest.
    #[error(transparent)]
    Unload(#[from] UnloadError),
    /// No equilibrium at a phase.
    #[error("at {phase}: {source}")]
    Phase { phase: String, source: SolveError },
    /// An unstable equilibrium.
    #[error(
        "at {phase}: the equilibrium is unstable, its stiffness has {negative_pivots} negative eigenvalues; the load is beyond what the body \
         bears at this theta"
    )]
    Unstable { phase: String, negative_pivots: usize },
    /// Derivatives that do not exist.
    #[error("at {state}: the places have no derivative in theta: {source}")]
    Slopes { state: String, source: UnloadError },
}

pub(super) type Result<T, E = StateError> = std::result::Result<T, E>;

impl From<StateError> for ForwardError {
    fn from(error: StateError) -> Self {
        Self { reason: error.to_string() }
    }
}
