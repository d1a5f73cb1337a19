//! What can go wrong, with the numbers and what to try.

use std::path::PathBuf;

/// Errors of emulators, data sets and training.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A configuration value admits no network.
    #[error("emulator configuration: {what} is {value}, but must be at least {minimum}")]
    Configuration {
        /// Name of the value.
        what: &'static str,
        /// The value given.
        value: usize,
        /// The smallest value allowed.
        minimum: usize,
    },
    /// An array does not have the length its meaning asks for.
    #[error(
        "{what}: {found} given, {expected} expected; check that geometry, topology, configuration and data belong together"
    )]
    Count {
        /// What was counted.
        what: &'static str,
        /// Number given.
        found: usize,
        /// Number expected.
        expected: usize,
    },
    /// An input holds NaN or an infinity.
    #[error(
        "{what} holds {value} at index {index}; remove or repair this entry before training or predicting"
    )]
    NotFinite {
        /// Which array.
        what: &'static str,
        /// Position in the flattened array.
        index: usize,
        /// The offending value.
        value: f64,
    },
    /// A parameter on the log scale is not positive.
    #[error(
        "parameter {parameter} is {value}, but its scale is logarithmic; give a positive value or choose the linear scale"
    )]
    LogOfNonPositive {
        /// Index of the parameter.
        parameter: usize,
        /// The offending value.
        value: f64,
    },
    /// A sample that training would extrapolate to.
    #[error(
        "parameter {parameter} of sample {sample} is {value}, outside its range [{lower}, {upper}]; check the units, or \
         widen the range"
    )]
    OutsideRange {
        /// Index of the sample, validation after training.
        sample: usize,
        /// Index of the parameter.
        parameter: usize,
        /// The offending value.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A parameter range is empty.
    #[error(
        "parameter {parameter} ranges from {lower} to {upper}; the upper bound must exceed the lower one"
    )]
    EmptyRange {
        /// Index of the parameter.
        parameter: usize,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A scale by which outputs or losses are divided is not positive.
    #[error(
        "{what} is {value}, but must be positive and finite; compute it from training displacements or from one linear solve"
    )]
    Scale {
        /// Which scale.
        what: &'static str,
        /// The value.
        value: f64,
    },
    /// The share of the budget that trains the node embeddings is none.
    #[error(
        "the share of the budget that trains the node embeddings is {0}; give a number from 0 to 1"
    )]
    EmbeddingShare(f64),
    /// Conjugate gradients did not find the linear response of a body.
    #[error(
        "the linear response was not found: after {iterations} iterations {left:.1e} of it is missing; hold the body, so \
         that no part of it moves without a force, and look for cells without volume"
    )]
    NoLinearResponse {
        /// Iterations made.
        iterations: usize,
        /// Root of the energy that is missing, relative to the first step's.
        left: f64,
    },
    /// A sample names a geometry the set does not have.
    #[error(
        "sample {sample} belongs to geometry {geometry}, but there are only {geometries} geometries"
    )]
    UnknownGeometry {
        /// Index of the sample.
        sample: usize,
        /// Geometry it names.
        geometry: usize,
        /// Number of geometries.
        geometries: usize,
    },
    /// Training without samples, or on a device that records no gradients.
    #[error("nothing to train on: {0}")]
    NothingToTrain(&'static str),
    /// A training value left the range of numbers.
    #[error(
        "training diverged at step {step}: loss {loss}, gradient norm {gradient_norm}, learning rate {learning_rate:.3e}; \
         resume from the last checkpoint with a learning rate of {:.1e} or less, or a larger batch",
        learning_rate / 3.0
    )]
    Diverged {
        /// Step, counted from one.
        step: usize,
        /// Loss of the step.
        loss: f64,
        /// Norm of the gradient before clipping.
        gradient_norm: f64,
        /// Learning rate of the step.
        learning_rate: f64,
    },
    /// A state to which the potential gives no energy.
    #[error(
        "at step {step} of the training {inadmissible} of {samples} predictions invert a cell, and their energy is not \
         finite; train on a potential with barriers (Body::with_barriers), begin from a displacement that \
         inverts no cell, or lower the learning rate"
    )]
    InvertedCells {
        /// Step, counted from one.
        step: usize,
        /// Predictions of the batch that invert a cell.
        inadmissible: usize,
        /// Size of the batch.
        samples: usize,
    },
    /// A prediction left the range of numbers.
    #[error(
        "the prediction for parameter set {sample} is not finite; the parameters are far outside the trained range or the weights are damaged"
    )]
    PredictionNotFinite {
        /// Index in the batch of parameters.
        sample: usize,
    },
    /// A backend this build does not contain.
    #[error("this build has no `{0}` backend; build with the cargo feature of that name")]
    MissingBackend(&'static str),
    /// A backend without a device.
    #[error(
        "this machine has no device for the backend `{0}`, or no driver of it; use another backend, such as flex"
    )]
    NoDevice(&'static str),
    /// A sample at which the potential cannot be evaluated.
    #[error("sample {sample} does not suit the potential: {reason}")]
    Parameters {
        /// Index of the sample, validation after training.
        sample: usize,
        /// What the potential objects to.
        reason: String,
    },
    /// A body whose stiffness cannot be formed.
    #[error(
        "the stiffness of the body is not finite at the displacement given: it inverts a cell, or an energy overflows; give a smaller one"
    )]
    NoStiffness,
    /// Parameters that do not suit a body.
    #[error(transparent)]
    Theta(#[from] sinew_energy::ThetaError),
    /// Features do not fit the graph.
    #[error(transparent)]
    Graph(sinew_graph::GraphError),
    /// Edges the kernels cannot address.
    #[error("edges of the topology: {0}")]
    Edges(#[from] sinew_burn::IndexError),
    /// A file could not be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file does not hold what was expected.
    #[error("{}: {reason}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A directory was written by another format version.
    #[error("{}: format version {found}, this build reads version {expected}; train again or use the build that wrote it", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// Version found.
        found: u32,
        /// Version read.
        expected: u32,
    },
}

/// Result with this crate's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// Requires `found == expected`.
pub(crate) fn require_count(what: &'static str, found: usize, expected: usize) -> Result<()> {
    if found == expected { Ok(()) } else { Err(Error::Count { what, found, expected }) }
}

/// Requires every value to be finite.
pub(crate) fn require_finite<T: Copy + Into<f64>>(what: &'static str, values: &[T]) -> Result<()> {
    let mut values = values.iter().map(|&value| value.into()).enumerate();
    match values.find(|(_, value)| !value.is_finite()) {
        None => Ok(()),
        Some((index, value)) => Err(Error::NotFinite { what, index, value }),
    }
}

/// Requires a positive, finite scale.
pub(crate) fn require_positive(what: &'static str, value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 { Ok(()) } else { Err(Error::Scale { what, value }) }
}
