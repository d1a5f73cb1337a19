//! Answers to an accuracy, quasi-Newton steps, regressions; coordinates, designs, simulations, estimates and what is stored of them.

mod anchors;
mod converge;
mod coordinates;
mod designs;
mod estimates;
mod motions;
mod no_potential;
mod processes;
mod progress;
mod recipes;
mod regression;
mod simulations;
mod spread;
mod stored;
mod to_an_accuracy;
