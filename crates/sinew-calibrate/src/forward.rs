//! Observables of a body at parameters, with derivatives.

/// Observables of a patient as functions of the parameters.
///
/// The physics (unloading, phases, volumes, strains) implements this; the statistics read nothing else.
pub trait Forward: Sync {
    /// Number of parameters.
    fn parameters(&self) -> usize;

    /// Number of observables.
    fn observables(&self) -> usize;

    /// Observables at θ, and their derivatives if `derivatives`.
    ///
    /// # Errors
    /// No unloaded body at θ, or no equilibrium at a phase.
    fn observe(&self, theta: &[f64], derivatives: bool) -> Result<Observed, ForwardError>;

    /// Announces θ, the centre first, among which most later ones lie. The default does nothing; a model may prepare for them.
    fn expect_among(&self, _thetas: &[Vec<f64>]) {}
}

/// Observables at one θ.
#[derive(Debug, Clone)]
pub struct Observed {
    /// One value per observable, in its own unit.
    pub values: Vec<f64>,
    /// One row per observable, one column per parameter; empty if not asked for.
    pub jacobian: Vec<Vec<f64>>,
}

/// A θ at which a body has no observables, with the reason.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{reason}")]
pub struct ForwardError {
    /// Reason in words, with numbers.
    pub reason: String,
}
