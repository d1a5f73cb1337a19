//! The thesis' beams: the comparison of emulators with the solver, and the report; and what the programs of all studies share.
//!
//! The program `sinew-study` runs them (`cargo xtask reproduce-beam`): [`scenes`] are lowered to bodies, `recipes` says how
//! `sinew-emulate` makes emulators of them, `sinew` compares them, `fenics` says how good the solver is that they are judged by.

mod fenics;
pub mod manifest;
pub mod options;
pub mod program;
mod recipes;
pub mod run;
pub mod samples;
pub mod scenes;
pub mod timing;
