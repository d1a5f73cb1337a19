//! What the study of the beams measures: methods, error measures, times and curves. `present` makes the report of it.

mod metric;
mod samples;
mod training;

pub use metric::{ErrorSamples, Method, MethodRow, Metric, PerMetric, ThesisReference, Times};
pub use samples::{SampleRow, SceneSamples, Spread, write_samples};
pub use training::{CurvePoint, EnergyPoint, TrainingHistory};
