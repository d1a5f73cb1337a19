//! Benchmarks of the finite-element solver against references that share no code with it.
//!
//! Each benchmark is a [`Case`], one file in [`cases`]. It gives [`Row`]s: a value beside its reference, with
//! error, stated band, unknowns and seconds. References come from [`mod@reference`]: closed forms, ordinary differential
//! equations and scalar equations, or constants of other programs with their source.
//!
//! ```
//! use sinew_studies::verify::{Effort, cases, run};
//!
//! let patch = cases::find("patch").expect("a case");
//! let outcome = run::run(patch, Effort::Quick);
//! assert!(outcome.passes());
//! assert!(outcome.rows.iter().all(|row| row.error <= row.band.most));
//! ```
//!
//! `cargo xtask verify` runs them all, prints the table, writes `report.json` and `report.html`, and ends with an
//! error when a value falls outside its band.

mod case;
pub mod cases;
mod integrate;
mod program;
pub mod reference;
mod report;
pub mod run;
mod solids;
mod solve;

pub use case::{Band, Case, Cost, Effort, Formulation, Label, Measure, Row, Rows};
pub use program::{Options, verify};
pub use report::{report, summary, table};
