//! Strain-energy laws, loads and the total potential energy of a mesh.

mod guard;
mod law;
pub mod laws;
mod potential;

pub use guard::{Barriers, Exact, Guard};
pub use law::{Law, Response};
pub use potential::TotalPotential;
