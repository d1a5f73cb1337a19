//! Every figure that the thesis prints beside ours: `cargo xtask thesis`, `docs/thesis.md`.
//!
//! [`printed`] reads the thesis' figures and the places of ours, [`stored`] keeps reports of runs, [`compare`] holds one against the
//! other, [`page`] writes it down, `counts` counts, [`picture`] draws it, [`filled`] fills tables of other pages, [`run`] runs what is missing.

pub mod compare;
pub mod filled;
pub mod page;
pub mod printed;
pub mod run;
pub mod stored;

pub use printed::{printed_median, thesis};
