//! What can be wrong with the samples.

/// Why a decomposition or its regression is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RegressionError {
    /// Too few samples.
    #[error("{found} simulations were given, at least 2 are needed, 25 is a good number")]
    TooFewSamples {
        /// Samples given.
        found: usize,
    },
    /// Not one field per parameter vector.
    #[error("{thetas} parameter vectors but {fields} fields: give one field per vector")]
    SampleCount {
        /// Parameter vectors given.
        thetas: usize,
        /// Fields given.
        fields: usize,
    },
    /// Samples of unlike length.
    #[error("sample {sample}: {expected} {what} expected, {found} found")]
    Length {
        /// What was counted.
        what: &'static str,
        /// The sample.
        sample: usize,
        /// Length expected, at least 1.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// A parameter that its scale has no place for.
    #[error(
        "parameter {parameter} of sample {sample} is {value}: it must be finite, and positive where it is sampled by its logarithm"
    )]
    Parameter {
        /// The sample.
        sample: usize,
        /// Name of the parameter.
        parameter: String,
        /// Its value.
        value: f64,
    },
    /// A field with a NaN or an infinity.
    #[error("value {index} of field {sample} is {value}: leave failed solves out")]
    Field {
        /// The sample.
        sample: usize,
        /// Index into the flattened field.
        index: usize,
        /// The value.
        value: f64,
    },
    /// The singular value decomposition failed.
    #[error(
        "no singular values of {samples} fields of {length} values, the largest being {largest:e}: \
         choose units in which the values are of order one"
    )]
    Decomposition {
        /// Fields.
        samples: usize,
        /// Values per field.
        length: usize,
        /// Largest magnitude of a value.
        largest: f64,
    },
}
