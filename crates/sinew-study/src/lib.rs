//! The thesis' beams: the comparison of emulators with the solver, and the report.
//!
//! The program `sinew-study` runs them (`cargo xtask reproduce-beam`). The story of a run:
//! [`scenes`] are lowered to bodies, `recipes` says how `sinew-emulate` makes emulators of them, `simulate` solves what
//! they are judged by, [`report`] tells.

pub mod fields;
pub mod manifest;
pub mod options;
mod outcome;
mod present;
pub mod program;
mod recipes;
pub mod report;
pub mod run;
pub mod scenes;
mod simulate;
pub mod timing;
