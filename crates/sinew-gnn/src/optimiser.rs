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
use update::{Moments, apply, collect, squared_norm};

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
        let mut updates = collect(emulator, gradients);
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
                updates.par_iter_mut().for_each(|update| update.by_adam(&rule));
            }
            OptimiserConfig::Muon(ref config) => muon::direct(config, self.steps, &mut updates),
        }
        let moments = updates.iter_mut().map(|u| (u.id.val(), std::mem::take(&mut u.moments)));
        self.moments.extend(moments);
        *emulator = apply(emulator.clone(), updates, learning_rate as f32);
        [value, norm]
    }
}

#[cfg(test)]
mod tests {
    use burn::module::Module;
    use burn::optim::{AdamConfig, ModuleOptimizer};
    use burn::tensor::Device;

    use super::*;
    use crate::GraphNetworkConfig;

    /// Sum of squares of one prediction, far from a minimum.
    fn loss(emulator: &GraphNetwork) -> Tensor<1> {
        let device = Device::flex().autodiff();
        let local = Tensor::ones([3, 2 * emulator.config().latent], &device);
        let parameters = Tensor::from_floats([[0.3, -0.8], [1.1, 0.2]], &device);
        let output = emulator.decode(vec![local], None, parameters).nodes;
        (output - 1.0).powi_scalar(2).sum()
    }

    #[test]
    fn steps_of_adam_are_those_of_burn_and_a_loss_that_is_not_finite_makes_none() {
        let mut config = GraphNetworkConfig::new(2, 1, 3, 2);
        (config.latent, config.width, config.steps) = (4, 8, 1);
        let rate = 0.01;
        let mut theirs: ModuleOptimizer = AdamConfig::new().with_epsilon(ADAM_EPSILON).init();
        let (mut ours, rule) = (Optimiser::default(), OptimiserConfig::adam());
        let start = GraphNetwork::new(&config, 5, &Device::flex()).unwrap().train();
        let (mut a, mut b) = (start.clone(), start);
        for _ in 0..3 {
            let (loss_a, loss_b) = (loss(&a), loss(&b));
            ours.step(&rule, (rate, None), &mut a, loss_a);
            let gradients = GradientsParams::from_grads(loss_b.backward(), &b);
            b = theirs.step(rate, b, gradients);
        }
        let outputs = |emulator: &GraphNetwork| -> Vec<f32> {
            let device = Device::flex();
            let local = Tensor::ones([3, 2 * config.latent], &device);
            let parameters = Tensor::from_floats([[0.3, -0.8]], &device);
            let output = emulator.valid().decode(vec![local], None, parameters).nodes;
            output.into_data().try_to_vec().unwrap()
        };
        for (a, b) in outputs(&a).iter().zip(outputs(&b)) {
            // Rounding: a direction is a quotient of small numbers of the order of one.
            assert!((a - b).abs() < 1e-5, "{a} for {b}");
        }
        let (before, history) = (outputs(&a), serde_json::to_string(&ours).unwrap());
        let lost = loss(&a) * f32::INFINITY;
        assert!(ours.step(&rule, (rate, None), &mut a, lost).iter().all(|x| !x.is_finite()));
        assert_eq!((outputs(&a), serde_json::to_string(&ours).unwrap()), (before, history));
    }

    #[test]
    fn moments_survive_storage_bit_for_bit_and_cut_ones_are_refused() {
        let first = vec![1.0, -0.0, f32::MIN_POSITIVE];
        let moments = Moments { first: first.clone(), second: vec![] };
        let text = serde_json::to_string(&moments).unwrap();
        let read: Moments = serde_json::from_str(&text).unwrap();
        assert_eq!(
            read.first.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
            first.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
        );
        assert!(read.second.is_empty());
        let cut = serde_json::to_string(&["AACA", ""]).unwrap();
        assert!(serde_json::from_str::<Moments>(&cut).is_err());
    }
}
