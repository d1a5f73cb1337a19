//! Answers to an accuracy, quasi-Newton steps, regressions.

mod anchors;
mod converge;
mod no_potential;
mod regression;
mod to_an_accuracy;
