//! Optimisers: Adam, and Muon as the published training figures used it.

mod update;

pub(crate) use update::collect;

use crate::fused::{momentum_direction, orthogonalise};
use crate::graph_network::GraphNetwork;
use burn::optim::GradientsParams;
use burn::tensor::Tensor;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use update::{Moments, Update, apply, bias_correction, squared_norm};

/// A choice of optimiser, as stored in configurations and checkpoints.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum OptimiserConfig {
    /// Adam (Kingma and Ba, 2015; thesis), in place: Burn's own goes through a chain of tensors for every parameter.
    Adam {
        /// Decay of the first moment.
        beta1: f32,
        /// Decay of the second moment.
        beta2: f32,
    },
    /// Muon on matrices, Adam on vectors.
    Muon(MuonConfig),
}

impl OptimiserConfig {
    /// Adam with its usual decays of 0.9 and 0.999.
    pub fn adam() -> Self {
        Self::Adam { beta1: 0.9, beta2: 0.999 }
    }
}

impl Default for OptimiserConfig {
    fn default() -> Self {
        Self::Muon(MuonConfig::default())
    }
}

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

impl MuonConfig {
    /// Turns a gradient into the direction of change, after `steps` steps.
    pub(super) fn direct(&self, steps: i32, update: &mut Update) {
        // Rows of embeddings are no layer of a network.
        if update.shape.len() != 2 || update.name.starts_with("embeddings") {
            let betas = [self.beta1, self.beta2];
            return update.by_adam(betas, steps, nesterov(self.beta1, steps));
        }
        let Update { gradient, moments, shape, .. } = update;
        let [of_momentum, of_gradient] = nesterov(self.momentum, steps);
        moments.first.resize(gradient.len(), 0.0);
        momentum_direction(self.momentum, of_momentum, of_gradient, &mut moments.first, gradient);
        orthogonalise(gradient, shape[1]);
        let scale = (shape[1] as f32 / shape[0] as f32).max(1.0).sqrt();
        gradient.iter_mut().for_each(|value| *value *= scale);
    }
}

/// Factors of momentum and gradient in the bias-corrected Nesterov momentum after `steps` steps.
fn nesterov(decay: f32, steps: i32) -> [f32; 2] {
    let left = |steps: i32| 1.0 - decay.powi(steps);
    [decay / left(steps + 1), (1.0 - decay) / left(steps)]
}

/// The history of an optimiser.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Optimiser {
    steps: usize,
    /// Moments by parameter.
    moments: BTreeMap<u64, Moments>,
}

impl Optimiser {
    /// One step down a loss, whose gradients are scaled so that their common Euclidean norm is at most `limit`. Returns the loss and
    /// that norm before; where one is not finite the weights stay as they are.
    pub(crate) fn step(
        &mut self,
        config: &OptimiserConfig,
        (learning_rate, limit): (f64, Option<f64>),
        emulator: &mut GraphNetwork,
        loss: Tensor<1>,
    ) -> [f64; 2] {
        let value: f64 = loss.clone().into_scalar::<f32>().into();
        let gradients = GradientsParams::from_grads(loss.backward(), emulator);
        let mut updates = collect(emulator, Some(gradients));
        // In the order of the module, so that it is reproducible.
        let norm = updates.iter().map(|update| squared_norm(&update.gradient)).sum::<f64>().sqrt();
        if !(value.is_finite() && norm.is_finite()) {
            return [value, norm];
        }
        let factor = limit.filter(|limit| norm > *limit).map(|limit| (limit / norm) as f32);
        for update in &mut updates {
            if let Some(factor) = factor {
                update.gradient.iter_mut().for_each(|g| *g *= factor);
            }
            update.moments = self.moments.remove(&update.id.val()).unwrap_or_default();
        }
        self.steps += 1;
        let steps = self.steps as i32;
        updates.par_iter_mut().for_each(|update| match config {
            OptimiserConfig::Adam { beta1, beta2 } => {
                update.by_adam([*beta1, *beta2], steps, [bias_correction(*beta1, steps), 0.0]);
            }
            OptimiserConfig::Muon(config) => config.direct(steps, update),
        });
        let moments = updates.iter_mut().map(|u| (u.id.val(), std::mem::take(&mut u.moments)));
        self.moments.extend(moments);
        *emulator = apply(emulator.clone(), updates, learning_rate as f32);
        [value, norm]
    }
}
