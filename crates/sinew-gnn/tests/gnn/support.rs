//! A small beam that bends under its own weight by a sixth to a third of its length.
#![allow(dead_code, reason = "each program uses a part")]

use sinew_emulate::Body;
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Parameter, Scene, Support};
use sinew_gnn::Network;
use sinew_gnn::{TrainingBudget, TrainingConfig};
use sinew_mesh::box_tetrahedra;

/// Weight of a density of 1 g/cm³ at g = 9.8 m/s² [kPa/mm].
const GRAVITY: f64 = 9.8e-3;

pub(crate) fn beam(weight: f64) -> Body {
    beam_held_at("x_min", weight)
}

pub(crate) fn beam_held_at(end: &str, weight: f64) -> Body {
    Scene::new(box_tetrahedra([40.0, 8.0, 8.0], [6, 2, 2]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
        .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
        .load(Load::BodyForce([0.0, 0.0, -weight * GRAVITY]))
        .support(Support::clamped(end))
        .lower()
        .expect("the beam is held and loaded")
}

/// A network that trains in seconds.
pub(crate) fn small_network() -> Network {
    Network {
        latent: 16,
        width: 32,
        cluster_width: 16,
        message_passing_steps: 3,
        virtual_nodes: None,
    }
}

pub(crate) fn steps(config: &TrainingConfig, steps: usize) -> TrainingConfig {
    TrainingConfig { budget: TrainingBudget::Steps(steps), ..config.clone() }
}
