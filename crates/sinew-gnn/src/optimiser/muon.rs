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
    update.by_adam(&AdamRule { beta1, beta2, of_first, of_gradient, of_second, epsilon });
}

/// Whether a parameter's direction of change is orthogonalised, as those of matrices are.
fn is_orthogonal(update: &Update) -> bool {
    update.shape.len() == 2 && !update.embeds
}

/// Factors of momentum and gradient in the bias-corrected Nesterov momentum after `steps` steps.
fn nesterov(decay: f32, steps: usize) -> (f32, f32) {
    let ahead = decay / (1.0 - decay.powi(steps as i32 + 1));
    (ahead, (1.0 - decay) / (1.0 - decay.powi(steps as i32)))
}

#[cfg(test)]
mod tests {
    use burn::module::ParamId;

    use super::*;
    use crate::optimiser::update::Moments;

    /// Directions of `optax.contrib.muon(1, adam_b2=0.99)`, optax 0.2.8, for the gradients of [`step`].
    const MATRIX: [[f32; 6]; 3] = [
        [1.092_780_4, 0.050_371_867, 0.541_692_3, 0.737_810_55, 0.614_565_3, -0.588_036_8],
        [0.972_244_6, 0.161_869_48, 0.598_933_64, 0.696_222_84, 0.696_166_04, -0.466_080_1],
        [0.650_668_8, -0.024_569_36, 0.786_948_86, 0.398_546_3, 0.729_152_1, -0.595_892_25],
    ];
    const VECTOR: [[f32; 3]; 3] = [
        [1.473_683_1, -1.473_681_6, 1.473_683_1],
        [0.654_090_64, -0.654_089_75, 0.654_090_64],
        [-0.175_093_68, 0.175_093_49, -0.175_093_74],
    ];

    fn gradient(values: &[f32], factor: f32, offset: f32) -> Vec<f32> {
        values.iter().map(|value| factor * value + offset).collect()
    }

    #[test]
    fn directions_are_those_of_optax() {
        let update = |id: u64, shape: Vec<usize>| Update {
            id: ParamId::from(id),
            embeds: false,
            shape,
            gradient: vec![],
            moments: Moments::default(),
        };
        let mut updates = [update(0, vec![2, 3]), update(1, vec![3])];
        for (step, (matrix, vector)) in MATRIX.iter().zip(&VECTOR).enumerate() {
            let k = step as f32;
            let of_matrix = [0.3, -0.2, 0.5, 0.1, 0.4, -0.6];
            updates[0].gradient = gradient(&of_matrix, 1.0 + k, 0.1 * k * k);
            updates[1].gradient = gradient(&[0.2, -0.01, 0.5], 1.0 - 0.8 * k, 0.0);
            direct(&MuonConfig::default(), step + 1, &mut updates);
            let expected = matrix.iter().chain(vector);
            let found = updates.iter().flat_map(|update| &update.gradient);
            for (expected, found) in expected.zip(found) {
                // Five iterations amplify rounding of single precision some tenfold.
                assert!((expected - found).abs() < 1e-5, "step {step}: {found} for {expected}");
            }
        }
    }
}
