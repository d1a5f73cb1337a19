//! Studies: the thesis' experiments, benchmarks of the solver, coverage of error estimates, posteriors of patients.
//!
//! Each is a list of scenes and a report: [`beams`] (`cargo xtask reproduce-beam`), [`organs`] (`reproduce-organs`), [`populations`]
//! (`reproduce-populations`), [`gp`] (`reproduce-gp`), [`calibration`] (`reproduce-calibration`), [`coverage`] (`coverage-estimates`), [`verify`]
//! (`verify`). [`thesis`] holds all printed figures against their reports. [`program`] is what they share. [`measure`]
//! prints single measurements that documents cite.

pub mod beams;
pub mod calibration;
pub mod coverage;
pub mod gp;
mod hearts;
pub mod measure;
pub mod organs;
pub mod populations;
pub mod program;
mod published;
mod shapes;
pub mod thesis;
mod ventricle_shape;
pub mod verify;
