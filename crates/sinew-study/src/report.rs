//! What the study of the beams compares, case by case. `present` makes the report of it.

mod method;
mod samples;

pub use method::{Method, ThesisReference};
pub use samples::{head, lines};
