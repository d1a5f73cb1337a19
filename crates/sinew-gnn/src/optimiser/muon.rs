//! Muon: momentum orthogonalised by Newton–Schulz iteration.

use crate::fused::{AdamRule, momentum_direction, orthogonalise};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::ADAM_EPSILON;
use super::update::Update;

/// Muon (K. Jordan, 2024) with Nesterov momentum on matrices, Adam with Nesterov momentum on
/// vectors and on embeddings that are weights, both at the same learning rate: the arithmetic of
/// `optax.contrib.muon`, which scales the orthogonal update of a matrix `[inputs, outputs]` by
/// √max(1, outputs / inputs).
/// (Burn's own Muon scales by the inverse ratio, has no bias correction and takes matrices only.)
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MuonConfig {
    /// Decay of the momentum of matrices.
    pub momentum: f32,
    /// Adam's decay of the first moment of vectors.
    pub beta1: f32,
    /// Adam's decay of the second moment of vectors.
    pub beta2: f32,
}

impl Default for MuonConfig {
    fn default() -> Self {
        Self { momentum: 0.95, beta1: 0.9, beta2: 0.99 }
    }
}

/// Turns gradients into directions of change, after `steps` steps.
pub(super) fn direct(config: &MuonConfig, steps: usize, updates: &mut [Update]) {
    updates.par_iter_mut().for_each(|update| {
        if is_orthogonal(update) {
            of_matrix(config.momentum, steps, update);
        } else {
            of_vector(config, steps, update);
        }
    });
}

fn of_matrix(momentum: f32, steps: usize, update: &mut Update) {
    let (of_momentum, of_gradient) = nesterov(momentum, steps);
    let Update { gradient, moments, .. } = update;
    moments.first.resize(gradient.len(), 0.0);
    momentum_direction(momentum, of_momentum, of_gradient, &mut moments.first, gradient);
    let (inputs, outputs) = (update.shape[0], update.shape[1]);
    orthogonalise(gradient, outputs);
    let scale = (outputs as f32 / inputs as f32).max(1.0).sqrt();
    gradient.iter_mut().for_each(|value| *value *= scale);
}

fn of_vector(config: &MuonConfig, steps: usize, update: &mut Update) {
    let MuonConfig { beta1, beta2, .. } = *config;
    let (of_first, of_gradient) = nesterov(beta1, steps);
    let of_second = 1.0 / (1.0 - beta2.powi(steps as i32));
    let epsilon = ADAM_EPSILON;
    update.by_adam(AdamRule { beta1, beta2, of_first, of_gradient, of_second, epsilon });
}

/// Whether a parameter's direction of change is orthogonalised, as those of matrices are.
fn is_orthogonal(update: &Update) -> bool {
    // Rows of embeddings are no layer of a network.
    update.shape.len() == 2 && !update.name.starts_with("embeddings")
}

/// Factors of momentum and gradient in the bias-corrected Nesterov momentum after `steps` steps.
fn nesterov(decay: f32, steps: usize) -> (f32, f32) {
    let ahead = decay / (1.0 - decay.powi(steps as i32 + 1));
    (ahead, (1.0 - decay) / (1.0 - decay.powi(steps as i32)))
}
