//! Values that the benchmarks are held to, computed by code that shares nothing with the solver.
//!
//! Closed forms, ordinary differential equations and scalar equations only: no mesh, no element, no law of
//! [`sinew_energy`]. Numbers of other programs are constants with their source in `published.rs`.

mod compressible_sphere;
mod cylinder;
mod elastica;
mod fung;
mod neo_hookean;
mod ode;
pub(crate) mod published;
mod roots;
mod sphere;

pub use compressible_sphere::{CompressibleSphere, Inflation};
pub use cylinder::ThickCylinder;
pub use elastica::{Elastica, Tip};
pub use fung::{Biaxial, Fung, Stretched};
pub use neo_hookean::{Bar, equibiaxial_bar, uniaxial_bar};
pub use ode::integrate;
pub use roots::{NoSignChange, root};
pub use sphere::{LimitPoint, ThickSphere};
