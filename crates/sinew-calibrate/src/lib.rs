//! From an image, pressures and a few measurements to the unloaded body and a posterior of its parameters.

mod forward;

pub use forward::{Forward, ForwardError, Observed};
