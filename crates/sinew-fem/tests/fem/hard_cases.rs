//! Bodies that are hard to solve, and problems that have no solution.
//!
//! Each case goes through the public interface and ends in a result that something independent confirms (a
//! closed form, a twin of the body, a finer mesh, the potential's own gradient), or in the error that names
//! what is wrong. None takes longer than seconds, none panics and none returns NaN.

mod beyond;
mod bodies;
mod checks;
mod curves;
mod elements;
mod estimates;
mod fibres;
mod held;
mod large_deformations;
mod loads;
mod loose_rims;
mod materials;
mod meshes;
mod overflow;
mod refused_input;
mod repeated_solves;
mod scales;
mod slender_bodies;
mod supports;
