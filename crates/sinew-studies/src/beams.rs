//! The thesis' two gravity beams: emulators against the solver.
//!
//! [`scenes`] are lowered to bodies, `recipes` says how emulators are made of them, `sinew` compares them, `fenics` measures the solver
//! that judges them.

pub mod options;
pub(crate) mod recipes;
pub mod run;
pub mod scenes;
