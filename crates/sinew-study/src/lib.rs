//! Studies: the thesis' scenes and experiments, the comparison of emulators with the solver, the report.
//!
//! The program `sinew-study` runs them (`cargo xtask reproduce-beam`). The story of a run:
//! [`scenes`] are lowered to potentials, [`simulate`] solves them, [`graph`] makes the emulator's
//! input, [`train`] trains, [`evaluate`] compares, [`report`] tells.
//!
//! [`gaussian`] holds the experiments with Gaussian processes (`cargo xtask reproduce-gp`).
//!
//! ```
//! use sinew_study::sampling::log_latin_hypercube;
//!
//! let stiffness = log_latin_hypercube(200, &[[50.0, 100.0], [50.0, 100.0]], 1);
//! assert!(stiffness.iter().all(|theta| theta.iter().all(|k| (50.0..=100.0).contains(k))));
//! ```

pub mod basis;
pub mod evaluate;
pub mod fields;
pub mod gaussian;
pub mod graph;
pub mod manifest;
pub mod options;
pub mod plan;
pub mod pod;
mod present;
pub mod progress;
pub mod report;
pub mod run;
pub mod sampling;
pub mod scenes;
pub mod simulate;
pub mod store;
pub mod timing;
pub mod train;
