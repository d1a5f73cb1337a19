//! Finite-element Newton solver for hyperelastic bodies
mod assembly;
mod cell;
mod dual;
mod error;
mod factor;
mod history;
mod load_steps;
mod newton;
mod order;
mod rigid;
mod sensitivity;
mod solution;
mod solver;
mod sparsity;
mod sweep;

pub use error::{Advice, NotConverged, SolveError};
pub use history::{History, Iteration};
pub use rigid::RigidMode;
pub use solution::{Options, Solution};
pub use solver::Solver;
pub use sweep::{Sweep, SweepError, sweep};
