//! Calibrations for people: progress, pressure–volume curve, sentences, report.

mod curve;
mod page;
mod run;
mod words;

pub use curve::Curve;
pub use page::{report, too_stiff};
pub use run::{arviz, in_words, observed};
pub use words::{parameter_in_words, verdict, volumes_in_words};
