//! Errors of coordinates and scales, and checks that several crates share.

/// Errors of coordinates and scales.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum CoordinateError {
    /// An array does not have the length its meaning asks for.
    #[error(
        "{what}: {found} given, {expected} expected; check that geometry, topology, configuration and data belong together"
    )]
    Count { what: &'static str, found: usize, expected: usize },
    /// An input holds NaN or an infinity.
    #[error(
        "{what} holds {value} at index {index}; remove or repair this entry before training or predicting"
    )]
    NotFinite { what: &'static str, index: usize, value: f64 },
    /// A parameter outside its scale or range, or an empty range.
    #[error("{0}")]
    Parameter(String),
    /// A scale by which outputs or losses are divided is not positive.
    #[error(
        "{what} is {value}, but must be positive and finite; compute it from training displacements or from one linear solve"
    )]
    Scale { what: &'static str, value: f64 },
    /// Clusters that cover no body, directions of simulations that do not differ, or a stiffness that cannot be formed.
    #[error("no coordinates: {0}")]
    None(&'static str),
    /// Parameters that do not suit a body.
    #[error(transparent)]
    Theta(#[from] sinew_energy::ThetaError),
}

/// Result with this crate's [`CoordinateError`].
pub(crate) type Result<T, E = CoordinateError> = std::result::Result<T, E>;

/// Requires that something holds.
pub(crate) fn ensure<E>(holds: bool, error: E) -> Result<(), E> {
    if holds { Ok(()) } else { Err(error) }
}

/// Requires `found == expected`.
///
/// # Errors
/// [`CoordinateError::Count`].
pub fn require_count(what: &'static str, found: usize, expected: usize) -> Result<()> {
    ensure(found == expected, CoordinateError::Count { what, found, expected })
}

/// Requires every value to be finite.
///
/// # Errors
/// [`CoordinateError::NotFinite`].
pub fn require_finite<T: Copy + Into<f64>>(what: &'static str, values: &[T]) -> Result<()> {
    let mut values = values.iter().map(|&value| value.into()).enumerate();
    let found = values.find(|(_, value)| !value.is_finite());
    found.map_or(Ok(()), |(index, value)| Err(CoordinateError::NotFinite { what, index, value }))
}

/// Requires a positive, finite scale.
///
/// # Errors
/// [`CoordinateError::Scale`].
pub fn require_positive(what: &'static str, value: f64) -> Result<()> {
    ensure(value.is_finite() && value > 0.0, CoordinateError::Scale { what, value })
}

/// Requires that a parameter has its place.
pub(super) fn require_parameter(holds: bool, reason: impl FnOnce() -> String) -> Result<()> {
    if holds { Ok(()) } else { Err(CoordinateError::Parameter(reason())) }
}
