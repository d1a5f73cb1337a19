//! Values that the benchmarks are held to, computed by code that shares nothing with the solver.
//!
//! Closed forms, ordinary differential equations and scalar equations only: no mesh, no element, no law of
//! [`sinew_energy`]. Numbers of other programs are constants with their source in `published.rs`.

mod elastica;
mod fung;
mod neo_hookean;
mod ode;
pub(crate) mod published;
mod roots;
mod walls;

pub use elastica::Elastica;
pub use fung::{Biaxial, Fung, Stretched};
pub use neo_hookean::neo_hookean_block;
pub use ode::integrate;
pub use roots::root;
pub use walls::{
    RADII, inflated_sphere, outer_radius, sphere_limit_point, sphere_pressure, tube_pressure,
};
