//! Adam, in place: Burn's own goes through a chain of tensors for every parameter.

use rayon::prelude::*;
use sinew_burn::AdamRule;

use super::ADAM_EPSILON;
use super::update::Update;

/// Turns gradients into directions of change, after `steps` steps with decays of the first and the second moment (Kingma and
/// Ba, 2015).
pub(super) fn direct([beta1, beta2]: [f32; 2], steps: usize, updates: &mut [Update]) {
    let correction = |beta: f32| 1.0 / (1.0 - beta.powi(steps as i32));
    let rule = AdamRule {
        beta1,
        beta2,
        of_first: correction(beta1),
        of_gradient: 0.0,
        of_second: correction(beta2),
        epsilon: ADAM_EPSILON,
    };
    updates.par_iter_mut().for_each(|update| update.by_adam(&rule));
}

#[cfg(test)]
mod tests {
    use burn::module::Module;
    use burn::optim::{AdamWConfig, GradientsParams, ModuleOptimizer};
    use burn::tensor::{Device, Tensor};

    use super::*;
    use crate::EmulatorConfig;
    use crate::emulator::Emulator;
    use crate::optimiser::{Optimiser, OptimiserConfig};

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
        let (beta1, beta2) = (0.9, 0.999);
        let mut ours = Optimiser::new(OptimiserConfig::AdamW { beta1, beta2, weight_decay: decay });
        let start = Emulator::new(&config, 5, &Device::flex()).unwrap().train();
        let (mut a, mut b) = (start.clone(), start);
        for _ in 0..3 {
            let (gradients_a, gradients_b) = (gradients(&a), gradients(&b));
            a = ours.step(rate, a, gradients_a);
            b = theirs.step(rate, b, gradients_b);
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
