//! Muon: momentum orthogonalised by Newton–Schulz iteration.

use std::collections::BTreeMap;
use std::path::Path;

use burn::module::{Module, ModuleMapper, ModuleVisitor, Param, ParamId};
use burn::optim::GradientsParams;
use burn::tensor::{DType, Device, Tensor, TensorData};
use serde::{Deserialize, Serialize};

use super::Optimiser;
use crate::emulator::Emulator;
use crate::error::{Error, Result};
use crate::files::{read_arrays, write_arrays};

/// Settings of [`Muon`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MuonConfig {
    /// Decay of the momentum of matrices.
    pub momentum: f32,
    /// Adam's decay of the first moment of vectors.
    pub beta1: f32,
    /// Adam's decay of the second moment of vectors.
    pub beta2: f32,
    /// Whether the decoders' matrices are updated by Adam too, as a stacked decoder is by optax.
    pub adam_on_decoders: bool,
}

impl Default for MuonConfig {
    fn default() -> Self {
        Self { momentum: 0.95, beta1: 0.9, beta2: 0.99, adam_on_decoders: false }
    }
}

/// Muon (K. Jordan, 2024) with Nesterov momentum on matrices, Adam with Nesterov momentum on
/// vectors and, if configured, on the decoders, both at the same learning rate: the arithmetic of
/// `optax.contrib.muon`, which scales the orthogonal update of a matrix `[inputs, outputs]` by
/// √max(1, outputs / inputs).
/// (Burn's own Muon scales by the inverse ratio, has no bias correction and takes matrices only.)
#[derive(Debug, Clone)]
pub struct Muon {
    config: MuonConfig,
    steps: usize,
    moments: BTreeMap<u64, Moments>,
}

/// First and second moment of one parameter; orthogonalised ones have no second one.
#[derive(Debug, Clone, Default)]
struct Moments {
    first: Vec<f32>,
    second: Vec<f32>,
}

/// Added to the root of Adam's second moment.
const EPSILON: f32 = 1e-8;

impl Muon {
    /// Without history.
    pub fn new(config: MuonConfig) -> Self {
        Self { config, steps: 0, moments: BTreeMap::new() }
    }

    /// Turns gradients into momenta where they are orthogonalised, into directions of change elsewhere.
    fn accumulate(&self, update: &mut Update) {
        let Update { gradient, moments, orthogonal, .. } = update;
        moments.first.resize(gradient.len(), 0.0);
        if *orthogonal {
            nesterov(self.config.momentum, self.steps, &mut moments.first, gradient);
        } else {
            moments.second.resize(gradient.len(), 0.0);
            self.adam(&mut moments.first, &mut moments.second, gradient);
        }
    }

    fn adam(&self, first: &mut [f32], second: &mut [f32], gradient: &mut [f32]) {
        let beta2 = self.config.beta2;
        for (v, g) in second.iter_mut().zip(gradient.iter()) {
            *v = beta2 * *v + (1.0 - beta2) * g * g;
        }
        nesterov(self.config.beta1, self.steps, first, gradient);
        let correction = 1.0 - beta2.powi(self.steps as i32);
        for (g, v) in gradient.iter_mut().zip(second.iter()) {
            *g /= (v / correction).sqrt() + EPSILON;
        }
    }
}

/// Replaces `gradient` by the bias-corrected Nesterov momentum after `steps` steps.
fn nesterov(decay: f32, steps: usize, momentum: &mut [f32], gradient: &mut [f32]) {
    let ahead = decay / (1.0 - decay.powi(steps as i32 + 1));
    let now = (1.0 - decay) / (1.0 - decay.powi(steps as i32));
    for (m, g) in momentum.iter_mut().zip(gradient) {
        *m = decay * *m + (1.0 - decay) * *g;
        *g = ahead * *m + now * *g;
    }
}

/// Turns the momenta of matrices into directions of change.
fn orthogonalise(updates: &mut [Update]) {
    let device = Device::flex();
    let mut matrices: Vec<&mut Update> =
        updates.iter_mut().filter(|update| update.orthogonal).collect();
    let momenta = matrices.iter_mut().map(|update| {
        let data = TensorData::new(std::mem::take(&mut update.gradient), update.shape.clone());
        Tensor::<2>::from_data(data, &device)
    });
    let directions = sinew_burn::orthogonalise(momenta.collect());
    for (update, direction) in matrices.into_iter().zip(directions) {
        let [inputs, outputs] = direction.dims();
        let scale = (outputs as f32 / inputs as f32).max(1.0).sqrt();
        update.gradient = numbers(direction);
        update.gradient.iter_mut().for_each(|value| *value *= scale);
    }
}

/// One parameter on its way through a step.
struct Update {
    id: ParamId,
    shape: Vec<usize>,
    /// Whether its direction of change is orthogonalised, as those of matrices are.
    orthogonal: bool,
    /// The gradient, then the direction of change.
    gradient: Vec<f32>,
    moments: Moments,
}

impl Optimiser for Muon {
    fn step(
        &mut self,
        learning_rate: f64,
        emulator: Emulator,
        gradients: GradientsParams,
    ) -> Emulator {
        self.steps += 1;
        let mut collector = Collector {
            gradients,
            moments: &mut self.moments,
            updates: Vec::new(),
            path: Vec::new(),
            adam_on_decoders: self.config.adam_on_decoders,
        };
        emulator.visit(&mut collector);
        let mut updates = collector.updates;
        updates.iter_mut().for_each(|update| self.accumulate(update));
        orthogonalise(&mut updates);
        let mut directions = BTreeMap::new();
        for update in updates {
            directions.insert(update.id, update.gradient);
            self.moments.insert(update.id.val(), update.moments);
        }
        emulator.map(&mut Mapper { directions, learning_rate: learning_rate as f32 })
    }

    fn save(&self, path: &Path) -> Result<()> {
        let ids = self.moments.keys().copied().collect::<Vec<_>>();
        let arrays = self.moments.values().flat_map(|m| [&m.first[..], &m.second[..]]);
        write_arrays(path, self.steps as u64, &ids, arrays)
    }

    fn load(&mut self, path: &Path) -> Result<()> {
        let (steps, ids, arrays) = read_arrays(path)?;
        if arrays.len() != 2 * ids.len() {
            let reason = format!("{} moments for {} parameters", arrays.len(), ids.len());
            return Err(Error::Format { path: path.into(), reason });
        }
        self.steps = steps as usize;
        let mut arrays = arrays.into_iter();
        let mut next = || arrays.next().unwrap_or_default();
        self.moments =
            ids.into_iter().map(|id| (id, Moments { first: next(), second: next() })).collect();
        Ok(())
    }
}

struct Collector<'a> {
    gradients: GradientsParams,
    moments: &'a mut BTreeMap<u64, Moments>,
    updates: Vec<Update>,
    /// Names of the modules around the parameter that is visited.
    path: Vec<String>,
    adam_on_decoders: bool,
}

impl ModuleVisitor for Collector<'_> {
    fn enter_module(&mut self, name: &str, _container_type: &str) {
        self.path.push(name.to_string());
    }

    fn exit_module(&mut self, _name: &str, _container_type: &str) {
        self.path.pop();
    }

    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        let decoder = self.path.iter().any(|name| name == "decoders");
        if let Some(gradient) = self.gradients.remove::<D>(param.id) {
            self.updates.push(Update {
                id: param.id,
                shape: gradient.dims().to_vec(),
                orthogonal: D == 2 && !(decoder && self.adam_on_decoders),
                gradient: numbers(gradient),
                moments: self.moments.remove(&param.id.val()).unwrap_or_default(),
            });
        }
    }
}

/// The numbers of a tensor in single precision.
fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    match tensor.dtype() {
        DType::F32 => tensor,
        _ => tensor.cast(DType::F32),
    }
    .into_data()
    .try_into_vec()
    .expect("the precision it was cast to")
}

struct Mapper {
    directions: BTreeMap<ParamId, Vec<f32>>,
    learning_rate: f32,
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
            for (value, change) in values.iter_mut().zip(direction) {
                *value -= self.learning_rate * change;
            }
            let weights = Tensor::from_data(TensorData::new(values, dims), &device);
            Tensor::from_inner(weights).set_require_grad(requires_gradient)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let mut muon = Muon::new(MuonConfig::default());
        let update = |id: u64, shape: Vec<usize>| Update {
            id: ParamId::from(id),
            orthogonal: shape.len() == 2,
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
            muon.steps += 1;
            updates.iter_mut().for_each(|update| muon.accumulate(update));
            orthogonalise(&mut updates);
            let expected = matrix.iter().chain(vector);
            let found = updates.iter().flat_map(|update| &update.gradient);
            for (expected, found) in expected.zip(found) {
                // Five iterations amplify rounding of single precision some tenfold.
                assert!((expected - found).abs() < 1e-5, "step {step}: {found} for {expected}");
            }
        }
    }
}
