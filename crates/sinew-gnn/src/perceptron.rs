//! Multilayer perceptrons with normalised outputs, from an explicit seed.

use crate::config::GraphNetworkConfig;
use crate::fused::{Activation, GatherPlan, Input, LayerNormalisation, PerceptronWeights};
use crate::fused::{VARIANCE_FLOOR, activate, gathered_mlp};
use burn::module::{Module, Param, ParamId};
use burn::tensor::{Device, Tensor, TensorData};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// `x W + b`.
#[derive(Module, Debug)]
pub(crate) struct Affine {
    /// `[inputs, outputs]`.
    pub weight: Param<Tensor<2>>,
    /// `[outputs]`.
    pub bias: Param<Tensor<1>>,
}

impl Affine {
    fn new(source: &mut Initialiser<'_>, inputs: usize, outputs: usize) -> Self {
        Self { weight: source.lecun_normal(inputs, outputs), bias: source.constant(0.0, [outputs]) }
    }

    pub(crate) fn forward(&self, x: Tensor<2>) -> Tensor<2> {
        x.matmul(self.weight.val()) + self.bias.val().unsqueeze()
    }

    /// Product of `x` with the rows of the weight that meet it, when the input is a
    /// concatenation and `x` its part starting at column `start`.
    pub(crate) fn partial(&self, x: Tensor<2>, start: usize) -> Tensor<2> {
        let end = start + x.dims()[1];
        x.matmul(self.weight.val().slice_dim(0, start..end))
    }
}

/// Layer normalisation over the last axis with gain and offset.
#[derive(Module, Debug)]
pub(crate) struct Normalisation {
    /// `[features]`.
    pub gain: Param<Tensor<1>>,
    /// `[features]`.
    pub offset: Param<Tensor<1>>,
}

impl Normalisation {
    pub(crate) fn new(source: &mut Initialiser<'_>, features: usize) -> Self {
        Self { gain: source.constant(1.0, [features]), offset: source.constant(0.0, [features]) }
    }

    /// Weights for [`fused`](crate::fused) operations.
    pub(crate) fn fused(&self) -> LayerNormalisation {
        let (gain, offset) = (self.gain.val(), self.offset.val());
        LayerNormalisation { gain, offset }
    }

    /// Normalised rows and their derivatives. Several directions share a value: row `i` of `tangent` belongs to row `i mod rows` of `x`.
    fn with_tangent(&self, x: Tensor<2>, tangent: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
        let directions = tangent.dims()[0] / x.dims()[0];
        let deviation = x.clone() - x.mean_dim(1);
        let variance = (deviation.clone() * deviation.clone()).mean_dim(1);
        let inverse = (variance + VARIANCE_FLOOR).sqrt().recip();
        let (normal, gain) = (deviation * inverse.clone(), self.gain.val().unsqueeze::<2>());
        let value = normal.clone() * gain.clone() + self.offset.val().unsqueeze();
        let [normal, inverse] = [normal, inverse].map(|x| x.repeat_dim(0, directions));
        let tangent = tangent.clone() - tangent.mean_dim(1);
        let along = (normal.clone() * tangent.clone()).mean_dim(1);
        (value, (tangent - normal * along) * inverse * gain)
    }
}

/// A perceptron with two hidden layers; its output is normalised where `normalisation` is present.
#[derive(Module, Debug)]
pub(crate) struct Perceptron {
    /// Three of them.
    pub layers: Vec<Affine>,
    normalisation: Option<Normalisation>,
    #[module(skip)]
    activation: Activation,
}

impl Perceptron {
    /// Perceptron with a normalised output.
    pub(crate) fn normalised(
        source: &mut Initialiser<'_>,
        config: &GraphNetworkConfig,
        inputs: usize,
    ) -> Self {
        let GraphNetworkConfig { width, latent, activation, .. } = *config;
        let layers = layers(source, &[inputs, width, width, latent]);
        let normalisation = Some(Normalisation::new(source, latent));
        Self { layers, normalisation, activation }
    }

    /// Decoder from inputs over hidden layers of a width to outputs, which are not normalised, and initially zero everywhere.
    pub(crate) fn decoder(
        source: &mut Initialiser<'_>,
        activation: Activation,
        [inputs, width, outputs]: [usize; 3],
    ) -> Self {
        let mut layers = layers(source, &[inputs, width, width]);
        let weight = source.constant(0.0, [width, outputs]);
        layers.push(Affine { weight, bias: source.constant(0.0, [outputs]) });
        Self { layers, normalisation: None, activation }
    }

    /// Output for whole inputs.
    pub(crate) fn forward(&self, x: Tensor<2>) -> Tensor<2> {
        let plan = GatherPlan::identity(x.dims()[0], 1);
        self.evaluate(vec![Input { values: x, first_row: Some(0) }], &plan)
    }

    /// Output for inputs whose parts are rows of `inputs`, as the plan tells.
    pub(crate) fn evaluate(&self, inputs: Vec<Input>, plan: &Arc<GatherPlan>) -> Tensor<2> {
        let layer = |k: usize| (self.layers[k].weight.val(), self.layers[k].bias.val());
        let layers = std::array::from_fn(layer);
        let normalisation = self.normalisation.as_ref().map(Normalisation::fused);
        let activation = self.activation;
        gathered_mlp(inputs, plan, PerceptronWeights { activation, layers, normalisation })
    }

    /// Value and derivative after the first affine map, whose own are `first` and `tangent`.
    /// Several directions share the value: row `i` of `tangent` belongs to row `i mod rows` of `first`.
    pub(crate) fn continue_with_tangent(
        &self,
        first: Tensor<2>,
        tangent: Tensor<2>,
    ) -> (Tensor<2>, Tensor<2>) {
        let directions = tangent.dims()[0] / first.dims()[0];
        let (mut value, mut tangent) = (first, tangent);
        for layer in &self.layers[1..] {
            let active = activate(value, self.activation);
            let slope = slope_of_active(active.clone(), self.activation);
            tangent = (tangent * slope.repeat_dim(0, directions)).matmul(layer.weight.val());
            value = layer.forward(active);
        }
        match &self.normalisation {
            Some(normalisation) => normalisation.with_tangent(value, tangent),
            None => (value, tangent),
        }
    }
}

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

/// Derivative of an activation, from its value.
fn slope_of_active(active: Tensor<2>, activation: Activation) -> Tensor<2> {
    match activation {
        Activation::Tanh => 1.0 - active.clone() * active,
        Activation::Celu => active.clamp_max(0.0) + 1.0,
    }
}

fn layers(source: &mut Initialiser<'_>, sizes: &[usize]) -> Vec<Affine> {
    sizes.windows(2).map(|pair| Affine::new(source, pair[0], pair[1])).collect()
}
