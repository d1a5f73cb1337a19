//! Optimisers: Adam, and Muon as the published training figures used it.

mod muon;
mod update;

pub use muon::MuonConfig;

use std::collections::BTreeMap;

use crate::fused::AdamRule;
use burn::optim::GradientsParams;
use burn::tensor::Tensor;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
pub(crate) use update::collect;
use update::{Moments, apply, squared_norm};

use crate::graph_network::GraphNetwork;

/// Added to the root of Adam's second moment.
const ADAM_EPSILON: f32 = 1e-8;

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
        match *config {
            OptimiserConfig::Adam { beta1, beta2 } => {
                let correction = |beta: f32| 1.0 / (1.0 - beta.powi(self.steps as i32));
                let (of_first, of_second) = (correction(beta1), correction(beta2));
                let (of_gradient, epsilon) = (0.0, ADAM_EPSILON);
                let rule = AdamRule { beta1, beta2, of_first, of_gradient, of_second, epsilon };
                updates.par_iter_mut().for_each(|update| update.by_adam(rule));
            }
            OptimiserConfig::Muon(ref config) => muon::direct(config, self.steps, &mut updates),
        }
        let moments = updates.iter_mut().map(|u| (u.id.val(), std::mem::take(&mut u.moments)));
        self.moments.extend(moments);
        *emulator = apply(emulator.clone(), updates, learning_rate as f32);
        [value, norm]
    }
}
