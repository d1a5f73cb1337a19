//! Properties of a law, and their violation.

use sinew_num::Mat3;
use thiserror::Error;

/// A property of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Property {
    /// No energy at rest.
    #[error("the energy at rest is zero")]
    EnergyAtRest,
    /// No stress at rest.
    #[error("the stress at rest is zero")]
    StressAtRest,
    /// Ψ(RF) = Ψ(F).
    #[error("rotation leaves the energy alone")]
    ObjectiveEnergy,
    /// P(RF) = R P(F).
    #[error("rotation turns the stress with it")]
    ObjectiveStress,
    /// ∂²Ψ/∂H∂H is symmetric.
    #[error("the tangent is symmetric")]
    SymmetricTangent,
    /// `energy`, `stress` and `response` give the energy of `density`.
    #[error("energy, stress and response give the same energy")]
    SameEnergy,
    /// Stress in closed form agrees with Taylor numbers.
    #[error("the stress agrees with Taylor numbers")]
    TaylorStress,
    /// Tangent in closed form agrees with jets.
    #[error("the tangent agrees with jets")]
    TaylorTangent,
    /// Stress agrees with central differences of the energy.
    #[error("the stress agrees with differences of the energy")]
    DifferenceStress,
    /// Tangent agrees with central differences of the stress.
    #[error("the tangent agrees with differences of the stress")]
    DifferenceTangent,
    /// Single precision keeps its digits at small strain.
    #[error("single precision keeps its digits at small strain")]
    SinglePrecision,
    /// No NaN as J → 0⁺, at overflow, or from a NaN.
    #[error("nothing is NaN near collapse and overflow")]
    NeverNan,
    /// +∞ at J ≤ 0.
    #[error("the energy is infinite at J <= 0")]
    InfiniteWhenInverted,
    /// Guards change nothing at admissible states.
    #[error("guards are the identity at admissible states")]
    GuardIdentity,
    /// Guarded energy and stress are finite on a tangled mesh.
    #[error("guarded energies are finite on a tangled mesh")]
    GuardFinite,
    /// The given parameters are within the law's bounds.
    #[error("the parameters given lie within the law's bounds")]
    Parameters,
}

/// A property that does not hold.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{law}: violated: {property}: found {found:e}, allowed {allowed:e}, at H = ({})", crate::listed(state.0.as_flattened()))]
pub struct Failure {
    /// Name of the law.
    pub law: &'static str,
    /// The property.
    pub property: Property,
    /// Displacement gradient where it fails.
    pub state: Mat3<f64>,
    /// The error found.
    pub found: f64,
    /// The error allowed.
    pub allowed: f64,
}
