//! Every figure that the thesis prints beside ours: `cargo xtask thesis`, `docs/thesis.md`.
//!
//! [`printed`] reads the thesis' figures and the places of ours, [`stored`] keeps reports of runs, [`compare`] holds one against the
//! other, [`page`] counts, draws it and writes it down, [`filled`] fills tables of other pages, [`run`] runs what is missing.

pub mod compare;
pub mod filled;
pub mod page;
pub mod printed;
pub mod run;
pub mod stored;

pub use printed::{printed_median, thesis};
