//! From an image, pressures and a few measurements to the unloaded body and a posterior of its parameters.

mod error;
mod forward;
mod observable;
mod observables;
mod patient;
mod segments;
mod setting;
mod wall;

pub use error::PatientError;
pub use forward::{Forward, ForwardError, Observed};
pub use observable::{At, Direction, Observable};
pub use patient::{Patient, PatientBuilder, PatientStates, StateError};
pub use segments::Segments;
pub use setting::Setting;
pub use wall::WallCoordinates;
