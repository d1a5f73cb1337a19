//! Initial weights from an explicit seed, the same on every backend.

use burn::module::{Param, ParamId};
use burn::tensor::{Device, Tensor, TensorData};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Standard deviation of a unit normal truncated to [−2, 2].
const TRUNCATED_DEVIATION: f64 = 0.879_625_661_034_239_8;

/// A source of parameters. Identities are consecutive numbers, so that two emulators of one
/// seed are equal in every respect.
pub(crate) struct Initialiser<'a> {
    random: ChaCha8Rng,
    next_id: u64,
    device: &'a Device,
}

impl<'a> Initialiser<'a> {
    pub(crate) fn new(seed: u64, device: &'a Device) -> Self {
        Self { random: ChaCha8Rng::seed_from_u64(seed), next_id: 1, device }
    }

    /// LeCun-normal weights `[inputs, outputs]`: truncated at two deviations, variance `1 / inputs`.
    pub(crate) fn lecun_normal(&mut self, inputs: usize, outputs: usize) -> Param<Tensor<2>> {
        let deviation = 1.0 / (TRUNCATED_DEVIATION * (inputs as f64).sqrt());
        let values =
            (0..inputs * outputs).map(|_| (deviation * self.truncated_normal()) as f32).collect();
        self.parameter(values, [inputs, outputs])
    }

    /// A parameter filled with one value.
    pub(crate) fn constant<const D: usize>(
        &mut self,
        value: f32,
        shape: [usize; D],
    ) -> Param<Tensor<D>> {
        self.parameter(vec![value; shape.iter().product()], shape)
    }

    fn parameter<const D: usize>(
        &mut self,
        values: Vec<f32>,
        shape: [usize; D],
    ) -> Param<Tensor<D>> {
        let id = ParamId::from(self.next_id);
        self.next_id += 1;
        let tensor = Tensor::from_data(TensorData::new(values, shape), self.device);
        Param::initialized(id, tensor).set_require_grad(true)
    }

    /// Unit normal by Box and Muller, drawn again outside [−2, 2].
    fn truncated_normal(&mut self) -> f64 {
        loop {
            let radius = (-2.0 * (1.0 - self.random.random::<f64>()).ln()).sqrt();
            let value = radius * (std::f64::consts::TAU * self.random.random::<f64>()).cos();
            if value.abs() <= 2.0 {
                return value;
            }
        }
    }
}
