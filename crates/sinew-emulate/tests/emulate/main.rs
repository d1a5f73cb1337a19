//! Answers to an accuracy, quasi-Newton steps, regressions.

mod anchors;
mod converge;
mod regression;
mod to_an_accuracy;
