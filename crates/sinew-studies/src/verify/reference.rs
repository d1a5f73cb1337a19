//! Values that the benchmarks are held to, computed by code that shares nothing with the solver.
//!
//! Closed forms, ordinary differential equations and scalar equations only: no mesh, no element, no law of
//! [`sinew_energy`]. Numbers of other programs are constants with their source in `published.rs`.

mod fung;
mod ode;
pub(crate) mod published;
mod walls;

pub use fung::{Biaxial, Fung, Stretched};
pub use ode::{Elastica, integrate, root};
pub use walls::{
    RADII, inflated_sphere, neo_hookean_block, outer_radius, sphere_limit_point, sphere_pressure,
    tube_pressure,
};
