//! What the example programs share: a soft bar that hangs from one end under its own weight.
//!
//! The programs are in `examples/examples`; start one with `cargo run -p sinew-examples --example NAME`.

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Parameter, Scene, SceneError, Support};
use sinew_mesh::box_tetrahedra;

/// A bar of 30 × 6 × 6 mm, clamped at x = 0; θ = (μ, λ) \[kPa\].
///
/// # Errors
/// None, unless the scene is changed to one that makes no sense.
pub fn bar() -> Result<Body, SceneError> {
    Scene::new(box_tetrahedra([30.0, 6.0, 6.0], [8, 2, 2]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
        .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
        .load(Load::BodyForce([0.0, 0.0, -9.8e-3])) // 1 g/cm³ under gravity [kPa/mm]
        .support(Support::clamped("x_min"))
        .lower()
}
