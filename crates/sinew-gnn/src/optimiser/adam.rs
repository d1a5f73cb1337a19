//! Adam, in place: Burn's own goes through a chain of tensors for every parameter.

use std::path::Path;

use burn::optim::GradientsParams;
use rayon::prelude::*;
use sinew_burn::{AdamRule, adam_direction};

use super::update::{AllMoments, Descent, apply, collect, read_moments, write_moments};
use super::{ADAM_EPSILON, Optimiser};
use crate::emulator::Emulator;
use crate::error::Result;

/// Adam (Kingma and Ba, 2015), with decoupled weight decay (Loshchilov and Hutter, 2019).
#[derive(Debug, Clone)]
pub(super) struct Adam {
    beta1: f32,
    beta2: f32,
    weight_decay: f32,
    steps: usize,
    moments: AllMoments,
}

impl Adam {
    /// Without history. `weight_decay` is the share of a weight lost per unit of learning rate.
    pub(super) fn new(beta1: f32, beta2: f32, weight_decay: f32) -> Self {
        Self { beta1, beta2, weight_decay, steps: 0, moments: AllMoments::new() }
    }

    fn rule(&self) -> AdamRule {
        let correction = |beta: f32| 1.0 / (1.0 - beta.powi(self.steps as i32));
        AdamRule {
            beta1: self.beta1,
            beta2: self.beta2,
            of_first: correction(self.beta1),
            of_gradient: 0.0,
            of_second: correction(self.beta2),
            epsilon: ADAM_EPSILON,
        }
    }
}

impl Optimiser for Adam {
    fn step(
        &mut self,
        learning_rate: f64,
        emulator: Emulator,
        gradients: GradientsParams,
    ) -> Emulator {
        self.steps += 1;
        let rule = self.rule();
        let mut updates = collect(&emulator, gradients, &mut self.moments);
        updates.par_iter_mut().for_each(|update| {
            let (gradient, moments) = (&mut update.gradient, &mut update.moments);
            moments.first.resize(gradient.len(), 0.0);
            moments.second.resize(gradient.len(), 0.0);
            adam_direction(&rule, &mut moments.first, &mut moments.second, gradient);
        });
        let step = learning_rate as f32;
        let descent = Descent { kept: 1.0 - step * self.weight_decay, step };
        apply(emulator, updates, &mut self.moments, descent)
    }

    fn save(&self, path: &Path) -> Result<()> {
        write_moments(path, self.steps, &self.moments)
    }

    fn load(&mut self, path: &Path) -> Result<()> {
        (self.steps, self.moments) = read_moments(path)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use burn::module::Module;
    use burn::optim::{AdamWConfig, ModuleOptimizer};
    use burn::tensor::{Device, Tensor};

    use super::*;
    use crate::EmulatorConfig;

    /// Sum of squares of one prediction, far from a minimum.
    fn gradients(emulator: &Emulator) -> GradientsParams {
        let device = Device::flex().autodiff();
        let local = Tensor::ones([3, 2 * emulator.config().latent], &device);
        let parameters = Tensor::from_floats([[0.3, -0.8], [1.1, 0.2]], &device);
        let output = emulator.decode(vec![local], None, parameters).nodes;
        let loss = (output - 1.0).powi_scalar(2).sum();
        GradientsParams::from_grads(loss.backward(), emulator)
    }

    #[test]
    fn steps_are_those_of_burn() {
        let mut config = EmulatorConfig::new(2, 1, 3, 2);
        (config.latent, config.width, config.steps) = (4, 8, 1);
        let (decay, rate) = (0.1, 0.01);
        let mut theirs: ModuleOptimizer =
            AdamWConfig::new().with_epsilon(ADAM_EPSILON).with_weight_decay(decay).init();
        let mut ours = Adam::new(0.9, 0.999, decay);
        let start = Emulator::new(&config, 5, &Device::flex()).unwrap().train();
        let (mut a, mut b) = (start.clone(), start);
        for _ in 0..3 {
            let (gradients_a, gradients_b) = (gradients(&a), gradients(&b));
            a = Optimiser::step(&mut ours, rate, a, gradients_a);
            b = Optimiser::step(&mut theirs, rate, b, gradients_b);
        }
        let outputs = |emulator: &Emulator| -> Vec<f32> {
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
    }
}
