//! Errors in the samples of a regression.

/// Why a decomposition or its regression is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum RegressionError {
    /// Too few samples.
    #[error("{found} simulations were given, at least 2 are needed, 25 is a good number")]
    TooFewSamples { found: usize },
    /// Not one field per parameter vector.
    #[error("{thetas} parameter vectors but {fields} fields: give one field per vector")]
    SampleCount { thetas: usize, fields: usize },
    /// Samples of unlike length.
    #[error("sample {sample}: {expected} {what} expected, {found} found")]
    Length { what: &'static str, sample: usize, expected: usize, found: usize },
    /// A parameter that is not finite, or not positive on a logarithmic scale.
    #[error(
        "parameter {parameter} of sample {sample} is {value}: it must be finite, and positive where it is sampled by its logarithm"
    )]
    Parameter { sample: usize, parameter: String, value: f64 },
    /// A field with a NaN or an infinity.
    #[error("value {index} of field {sample} is {value}: leave failed solves out")]
    Field { sample: usize, index: usize, value: f64 },
    /// The singular value decomposition failed.
    #[error(
        "no singular values of {samples} fields of {length} values, the largest being {largest:e}: \
         choose units in which the values are of order one"
    )]
    Decomposition { samples: usize, length: usize, largest: f64 },
}
