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
    /// A parameter on the log scale is not positive.
    #[error(
        "parameter {parameter} is {value}, but its scale is logarithmic; give a positive value or choose the linear scale"
    )]
    LogOfNonPositive { parameter: usize, value: f64 },
    /// A sample that training would extrapolate to.
    #[error(
        "parameter {parameter} of sample {sample} is {value}, outside its range [{lower}, {upper}]; check the units, or \
         widen the range"
    )]
    OutsideRange { sample: usize, parameter: usize, value: f64, lower: f64, upper: f64 },
    /// A parameter range is empty.
    #[error(
        "parameter {parameter} ranges from {lower} to {upper}; the upper bound must exceed the lower one"
    )]
    EmptyRange { parameter: usize, lower: f64, upper: f64 },
    /// A scale by which outputs or losses are divided is not positive.
    #[error(
        "{what} is {value}, but must be positive and finite; compute it from training displacements or from one linear solve"
    )]
    Scale { what: &'static str, value: f64 },
    /// Clusters that cover no body, or directions of simulations that do not differ.
    #[error("no coordinates: {0}")]
    None(&'static str),
    /// A body whose stiffness cannot be formed.
    #[error(
        "the stiffness of the body is not finite at the displacement given: it inverts a cell, or an energy overflows; give a smaller one"
    )]
    NoStiffness,
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
