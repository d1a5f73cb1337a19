//! Graph-network emulators of a body: trained on simulations, on potential energy, or on both.
//!
//! A soft bar, emulated by the recipe that does best on held-out simulations, a network among the candidates:
//!
//! ```
//! use sinew_emulate::TrainingOptions;
//! use sinew_energy::{Load, Parameter, Scene, Support, laws::NeoHookean};
//! use sinew_networks::Recipe;
//!
//! let body = Scene::new(sinew_mesh::box_tetrahedra([40.0, 8.0, 8.0], [6, 2, 2]), NeoHookean)
//!     .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
//!     .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
//!     .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // 1 g/cm³ · 9.8 m/s² [kPa/mm]
//!     .support(Support::clamped("x_min"))
//!     .lower()?;
//! let emulator = Recipe::auto().train(&body, &TrainingOptions::default(), &mut ())?;
//! println!("{}", emulator.record.choice.as_ref().ok_or("auto chooses")?);
//! let prediction = emulator.predict(&[vec![10.0, 12.0]])?;
//! assert!(emulator.estimate(&prediction, 0)?.distance.ok_or("an equilibrium is near")?.mean < 1e-3); // mm
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`Recipe`] names all recipes: networks ([`recipe::DataDriven`], [`recipe::PhysicsInformed`], [`recipe::Hybrid`]), what beats them on
//!   one geometry ([`recipe::Regression`], the Taylor expansion [`Recipe::Taylor`]), and [`recipe::Auto`], which chooses by errors on
//!   held-out cases.
//! - [`load`]: an emulator from its folder, be it a network or not.

mod budget;
mod coordinates;
mod error;
mod graph;
mod network;
pub mod recipe;

pub use coordinates::Coordinates;
pub use error::{Error, Result};
pub use network::{KINDS, Network};
pub use recipe::{Recipe, train};
pub use sinew_gnn::Backend;

use sinew_emulate::{Body, Emulator};
use std::path::Path;

/// Reads an emulator of `body`, be its predictor a network or not.
///
/// # Errors
/// As [`Emulator::load`].
pub fn load<'b>(folder: &Path, body: &'b Body) -> sinew_emulate::Result<Emulator<'b>> {
    Emulator::load_with(folder, body, KINDS)
}
