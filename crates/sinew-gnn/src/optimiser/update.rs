//! Gradients and weights of a network as plain numbers, updated in place.

use std::collections::BTreeMap;

use crate::fused::{AdamRule, adam_direction, descend};
use burn::module::{Module, ModuleMapper, ModuleVisitor, Param, ParamId};
use burn::optim::GradientsParams;
use burn::tensor::{DType, Tensor, TensorData};
use serde::{Deserialize, Serialize};

use crate::graph_network::GraphNetwork;
use sinew_emulate::coordinates::packed;

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
    /// Turns the gradient into Adam's direction of change after `steps` steps, for factors of the first moment and of the
    /// gradient itself.
    pub(super) fn by_adam(
        &mut self,
        [beta1, beta2]: [f32; 2],
        steps: i32,
        [of_first, of_gradient]: [f32; 2],
    ) {
        let Self { gradient, moments, .. } = self;
        let of_second = bias_correction(beta2, steps);
        let rule = AdamRule { beta1, beta2, of_first, of_gradient, of_second };
        moments.first.resize(gradient.len(), 0.0);
        moments.second.resize(gradient.len(), 0.0);
        adam_direction(rule, &mut moments.first, &mut moments.second, gradient);
    }
}

/// Factor of a moment that begins at zero, after `steps` steps.
pub(super) fn bias_correction(decay: f32, steps: i32) -> f32 {
    1.0 / (1.0 - decay.powi(steps))
}

/// Gradients of all parameters that have one, or all weights.
pub(crate) fn collect(emulator: &GraphNetwork, gradients: Option<GradientsParams>) -> Vec<Update> {
    let mut collector = Collector { gradients, updates: Vec::new(), path: Vec::new() };
    emulator.visit(&mut collector);
    collector.updates
}

/// Moves the weights by so much along the directions.
pub(super) fn apply(emulator: GraphNetwork, updates: Vec<Update>, step: f32) -> GraphNetwork {
    let directions = updates.into_iter().map(|update| (update.id, update.gradient)).collect();
    emulator.map(&mut Mapper { directions, step })
}

/// Sum in interleaved partial sums, which the compiler turns into vectors.
pub(super) fn squared_norm(values: &[f32]) -> f64 {
    let mut lanes = [0.0; 8];
    for chunk in values.chunks(lanes.len()) {
        for (lane, value) in lanes.iter_mut().zip(chunk) {
            *lane += f64::from(*value) * f64::from(*value);
        }
    }
    lanes.iter().sum()
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
