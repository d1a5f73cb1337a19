//! The thesis' two gravity beams: emulators against the solver.
//!
//! [`scenes`] are lowered to bodies, `recipes` says how emulators are made of them, `run` compares them. [`scenes`] also measures the solver
//! that judges them.

pub mod options;
pub(crate) mod recipes;
pub mod run;
pub mod scenes;
