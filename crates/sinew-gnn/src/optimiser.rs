//! Optimisers: Adam, and Muon as the published training figures used it; gradients and weights of a network as plain numbers.

use crate::fused::{
    AdamRule, adam_direction, descend, momentum_direction, orthogonalise, squared_norm,
};
use crate::graph_network::GraphNetwork;
use burn::module::{Module, ModuleMapper, ModuleVisitor, Param, ParamId};
use burn::optim::GradientsParams;
use burn::tensor::{DType, Tensor, TensorData};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sinew_emulate::coordinates::packed;
use std::collections::BTreeMap;

/// A choice of optimiser, as stored in configurations and checkpoints.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum OptimiserConfig {
    /// Adam (Kingma and Ba, 2015; thesis), in place: Burn's own goes through a chain of tensors for every parameter.
    Adam {
        /// Decay of the first moment.
        beta1: f32,
        /// Decay of the second moment.
        beta2: f32,
    },
    /// Muon (K. Jordan, 2024) with Nesterov momentum on matrices, Adam with Nesterov momentum on
    /// vectors and on embeddings that are weights, both at the same learning rate: the arithmetic of
    /// `optax.contrib.muon`, which scales the orthogonal update of a matrix `[inputs, outputs]` by
    /// √max(1, outputs / inputs).
    /// (Burn's own Muon scales by the inverse ratio, has no bias correction and takes matrices only.)
    #[default]
    Muon,
}

impl OptimiserConfig {
    /// Adam with its usual decays of 0.9 and 0.999.
    pub fn adam() -> Self {
        Self::Adam { beta1: 0.9, beta2: 0.999 }
    }
}

/// Muon's decay of the momentum of matrices, and of both moments of vectors.
const MOMENTUM: f32 = 0.95;
const OF_VECTORS: [f32; 2] = [0.9, 0.99];

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
            OptimiserConfig::Muon => update.by_muon(steps),
        });
        let moments = updates.iter_mut().map(|u| (u.id.val(), std::mem::take(&mut u.moments)));
        self.moments.extend(moments);
        let directions = updates.into_iter().map(|update| (update.id, update.gradient)).collect();
        *emulator = emulator.clone().map(&mut Mapper { directions, step: learning_rate as f32 });
        [value, norm]
    }
}

/// First and second moment of one parameter's gradient; a rule that needs none leaves it empty.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(try_from = "[String; 2]", into = "[String; 2]")]
pub(crate) struct Moments {
    pub first: Vec<f32>,
    pub second: Vec<f32>,
}

impl From<Moments> for [String; 2] {
    fn from(moments: Moments) -> Self {
        [packed::singles(&moments.first), packed::singles(&moments.second)]
    }
}

impl TryFrom<[String; 2]> for Moments {
    type Error = String;

    fn try_from([first, second]: [String; 2]) -> Result<Self, String> {
        Ok(Self { first: packed::read_singles(&first)?, second: packed::read_singles(&second)? })
    }
}

/// One parameter on its way through a step.
pub(crate) struct Update {
    pub id: ParamId,
    /// Place in the network, as `decoders.0.layers.2.bias`.
    pub name: String,
    pub shape: Vec<usize>,
    /// The gradient, then the direction of change; where no gradients are collected, the weights.
    pub gradient: Vec<f32>,
    pub moments: Moments,
}

impl Update {
    /// Muon's direction of change after `steps` steps, in place of the gradient.
    fn by_muon(&mut self, steps: i32) {
        // Rows of embeddings are no layer of a network.
        if self.shape.len() != 2 || self.name.starts_with("embeddings") {
            return self.by_adam(OF_VECTORS, steps, nesterov(OF_VECTORS[0], steps));
        }
        let Self { gradient, moments, shape, .. } = self;
        let [of_momentum, of_gradient] = nesterov(MOMENTUM, steps);
        moments.first.resize(gradient.len(), 0.0);
        momentum_direction(MOMENTUM, of_momentum, of_gradient, &mut moments.first, gradient);
        orthogonalise(gradient, shape[1]);
        let scale = (shape[1] as f32 / shape[0] as f32).max(1.0).sqrt();
        gradient.iter_mut().for_each(|value| *value *= scale);
    }

    /// Turns the gradient into Adam's direction of change after `steps` steps, for factors of the first moment and of the
    /// gradient itself.
    fn by_adam(&mut self, [beta1, beta2]: [f32; 2], steps: i32, [of_first, of_gradient]: [f32; 2]) {
        let Self { gradient, moments, .. } = self;
        let of_second = bias_correction(beta2, steps);
        let rule = AdamRule { beta1, beta2, of_first, of_gradient, of_second };
        moments.first.resize(gradient.len(), 0.0);
        moments.second.resize(gradient.len(), 0.0);
        adam_direction(rule, &mut moments.first, &mut moments.second, gradient);
    }
}

/// Factor of a moment that begins at zero, after `steps` steps.
fn bias_correction(decay: f32, steps: i32) -> f32 {
    1.0 / (1.0 - decay.powi(steps))
}

/// Gradients of all parameters that have one, or all weights.
pub(crate) fn collect(emulator: &GraphNetwork, gradients: Option<GradientsParams>) -> Vec<Update> {
    let mut collector = Collector { gradients, updates: Vec::new(), path: Vec::new() };
    emulator.visit(&mut collector);
    collector.updates
}

/// The numbers of a tensor in single precision.
fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    let data = tensor.cast(DType::F32).into_data();
    data.try_into_vec().expect("the precision it was cast to")
}

struct Collector {
    gradients: Option<GradientsParams>,
    updates: Vec<Update>,
    /// Names of the modules around the parameter that is visited.
    path: Vec<String>,
}

impl ModuleVisitor for Collector {
    fn enter_module(&mut self, name: &str, _container_type: &str) {
        self.path.push(name.to_string());
    }

    fn exit_module(&mut self, _name: &str, _container_type: &str) {
        self.path.pop();
    }

    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        let found = match &mut self.gradients {
            Some(gradients) => gradients.remove::<D>(param.id),
            None => Some(param.val()),
        };
        if let Some(tensor) = found {
            self.updates.push(Update {
                id: param.id,
                name: self.path.join("."),
                shape: tensor.dims().to_vec(),
                gradient: numbers(tensor),
                moments: Moments::default(),
            });
        }
    }
}

/// Moves the weights by so much along the directions.
struct Mapper {
    directions: BTreeMap<ParamId, Vec<f32>>,
    step: f32,
}

impl ModuleMapper for Mapper {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let Some(direction) = self.directions.remove(&param.id) else {
            return param;
        };
        param.map(|weights| {
            let requires_gradient = weights.is_require_grad();
            let (device, dims) = (weights.device().without_autodiff(), weights.dims());
            let mut values = numbers(weights.without_autodiff());
            descend(self.step, &direction, &mut values);
            let weights = Tensor::from_data(TensorData::new(values, dims), &device);
            Tensor::from_inner(weights).set_require_grad(requires_gradient)
        })
    }
}
