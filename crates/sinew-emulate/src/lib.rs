//! From a body to an emulator that knows its error.

mod calibration;
mod coordinates;
mod correction;
mod emulator;
mod error;
mod evaluate;
mod graph;
mod identity;
mod network;
mod options;
mod parameters;
mod progress;
mod quantiles;
pub mod recipe;
mod regression;
mod sampling;
mod session;
mod simulate;
mod store;
#[cfg(feature = "terminal")]
mod terminal;
mod timing;
mod warning;

pub use calibration::Calibration;
pub use coordinates::Coordinates;
pub use correction::{Correction, Estimate};
pub use emulator::{Emulator, Prediction, Record};
pub use error::{Error, Result};
pub use evaluate::{CaseErrors, Errors, TestSet, median_and_worst};
pub use network::{CurvePoint, Network};
pub use options::{Budget, TrainingOptions};
pub use progress::{Observer, Progress};
pub use quantiles::Quantiles;
pub use recipe::Recipe;
pub use regression::{Interpolation, PodRegression, RegressionError};
pub use sampling::Design;
pub use simulate::{Failure, Simulations, simulate};
#[cfg(feature = "terminal")]
pub use terminal::Terminal;
pub use sinew_energy::Body;
pub use timing::median_seconds;
pub use warning::Warning;
