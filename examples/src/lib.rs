//! What the example programs share: a soft bar that hangs from one end under its own weight.
//!
//! The programs are in `examples/examples`; start one with `cargo run -p sinew-examples --example NAME`.

use sinew_energy::laws::NeoHookean;
use sinew_energy::{Body, Load, Parameter, Sampling, Scene, SceneError, Support, Units};
use sinew_mesh::box_tetrahedra;

/// A bar of 30 × 6 × 6 mm, clamped at x = 0; θ = (μ, λ) \[kPa\].
///
/// # Errors
/// None, unless the scene is changed to one that makes no sense.
pub fn bar() -> Result<Body, SceneError> {
    let stiffness = |name: &str| Parameter {
        name: name.into(),
        unit: "kPa".into(),
        range: [8.0, 16.0],
        sampling: Sampling::Log,
    };
    let scene = Scene {
        name: "bar".into(),
        units: Units::mm_kpa(),
        mesh: box_tetrahedra([30.0, 6.0, 6.0], [8, 2, 2]),
        law: NeoHookean,
        directions: Vec::new(),
        parameters: vec![stiffness("mu"), stiffness("lambda")],
        loads: vec![Load::BodyForce([0.0, 0.0, -9.8e-3])], // 1 g/cm³ under gravity [kPa/mm]
        supports: vec![Support::clamped("x_min")],
    };
    scene.lower()
}
