//! Populations: unseen shapes by a frozen stiffness, Taylor expansions, and regression on simulations of registered
//! shapes, beside the solver; networks of the thesis' chapter 2: `cargo xtask reproduce-populations`.
//!
//! `rectangles` and `inflated` are the plane beams and the ventricles of that chapter, networks on simulations (`simulated`, `variant`, `rows`). `stage` draws individuals, `rivals` simulates and regresses, `measure` takes errors raw and corrected, `verdict` compares the errors of the classes, `section` tells it, [`run`] makes the report.

mod inflated;
mod measure;
mod nested;
pub mod options;
mod prolongation;
mod rectangles;
mod rivals;
mod rows;
pub mod run;
mod section;
mod simulated;
mod stage;
mod variant;
mod verdict;
