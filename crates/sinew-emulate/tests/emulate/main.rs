//! Answers to an accuracy, quasi-Newton steps, regressions; coordinates, designs, simulations, estimates and what is stored of them.

#[expect(dead_code, reason = "studies take hexahedra too")]
#[path = "../../../sinew-studies/src/ventricle_shape.rs"]
mod ventricle_shape;

mod anchors;
mod converge;
mod coordinates;
mod designs;
mod estimates;
mod left_to_a_sweep;
mod motions;
mod no_potential;
mod processes;
mod progress;
mod recipes;
mod regression;
mod simulations;
mod spread;
mod stored;
mod stored_runs;
mod to_an_accuracy;
