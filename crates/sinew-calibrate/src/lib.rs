//! From an image, pressures and a few measurements to the unloaded body and a posterior of its parameters.

mod calibrate;
mod correction;
mod datum;
mod fault;
mod forward;
mod identifiability;
mod likelihood;
mod mode;
mod polynomial;
mod posterior;
mod predictive;
mod prior;
mod problem;
mod solves;
mod verify;

pub use calibrate::{CalibrateOptions, calibrate, look_ahead};
pub use correction::Correction;
pub use datum::{Datum, Kind};
pub use fault::CalibrateError;
pub use forward::{Forward, ForwardError, Observed};
pub use identifiability::{Decided, Identifiability};
pub use mode::Mode;
pub use posterior::Posterior;
pub use predictive::{DatumCheck, Predictive};
pub use prior::{Prior, Unknown};
pub use problem::Problem;
pub use solves::{Answer, Solves};
