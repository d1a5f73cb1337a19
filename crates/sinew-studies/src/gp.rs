//! The thesis' experiments with priors that satisfy boundary conditions exactly (§4.8), and its first
//! physics-informed network (§1.7.3): `cargo xtask reproduce-gp`.
//!
//! An [`experiment`] is a list of cases: a method on a problem, run on several data sets. [`reproduce_gp`] works them
//! off, stores every fit as it ends, and gathers medians into [`row`]s; [`report`] tells.

mod deep;
mod draw;
pub mod experiment;
pub mod experiments;
mod floor;
mod hcnn;
mod inference;
mod pentagon;
mod problems;
pub mod report;
pub mod row;
mod run;
mod workers;

pub use run::{Options, reproduce_gp};
