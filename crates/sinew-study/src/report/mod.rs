//! What the study of the beams measures: methods, error measures and times. `present` makes the report of it.

mod metric;
mod samples;

pub use metric::{ErrorSamples, Method, MethodRow, Metric, PerMetric, ThesisReference, Times};
pub use samples::{SampleRow, SceneSamples, Spread, write_samples};
