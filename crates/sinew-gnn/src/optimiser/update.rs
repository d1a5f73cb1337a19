//! Gradients and weights of a network as plain numbers, updated in place.

use std::collections::BTreeMap;
use std::path::Path;

use burn::module::{Module, ModuleMapper, ModuleVisitor, Param, ParamId};
use burn::optim::GradientsParams;
use burn::tensor::{DType, Tensor, TensorData};
use sinew_burn::{AdamRule, adam_direction, descend};

use crate::emulator::Emulator;
use crate::error::{Error, Result};
use crate::files::{read_arrays, write_arrays};

/// First and second moment of one parameter's gradient; a rule that needs none leaves it empty.
#[derive(Debug, Clone, Default)]
pub(super) struct Moments {
    pub first: Vec<f32>,
    pub second: Vec<f32>,
}

/// Moments by parameter.
pub(super) type AllMoments = BTreeMap<u64, Moments>;

/// What a parameter belongs to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// A perceptron that is no decoder, or a normalisation.
    Network,
    /// A decoder.
    Decoder,
    /// The embeddings of a geometry, whose rows are no layer of a network.
    Embeddings,
}

/// One parameter on its way through a step.
pub(super) struct Update {
    pub id: ParamId,
    pub shape: Vec<usize>,
    pub place: Place,
    /// The gradient, then the direction of change.
    pub gradient: Vec<f32>,
    pub moments: Moments,
}

impl Update {
    /// Turns the gradient into Adam's direction of change.
    pub(super) fn by_adam(&mut self, rule: &AdamRule) {
        let Self { gradient, moments, .. } = self;
        moments.first.resize(gradient.len(), 0.0);
        moments.second.resize(gradient.len(), 0.0);
        adam_direction(rule, &mut moments.first, &mut moments.second, gradient);
    }
}

/// How weights follow a direction: `kept · weight − step · direction`.
#[derive(Clone, Copy)]
pub(super) struct Descent {
    pub kept: f32,
    pub step: f32,
}

/// Takes gradients and moments of all parameters that have a gradient.
pub(super) fn collect(
    emulator: &Emulator,
    gradients: GradientsParams,
    moments: &mut AllMoments,
) -> Vec<Update> {
    let mut collector = Collector { gradients, moments, updates: Vec::new(), path: Vec::new() };
    emulator.visit(&mut collector);
    collector.updates
}

/// Moves the weights along the directions, and gives the moments back.
pub(super) fn apply(
    emulator: Emulator,
    updates: Vec<Update>,
    moments: &mut AllMoments,
    descent: Descent,
) -> Emulator {
    let mut directions = BTreeMap::new();
    for update in updates {
        directions.insert(update.id, update.gradient);
        moments.insert(update.id.val(), update.moments);
    }
    emulator.map(&mut Mapper { directions, descent })
}

/// Writes moments and number of steps to a file.
pub(super) fn write_moments(path: &Path, steps: usize, moments: &AllMoments) -> Result<()> {
    let ids = moments.keys().copied().collect::<Vec<_>>();
    let arrays = moments.values().flat_map(|m| [&m.first[..], &m.second[..]]);
    write_arrays(path, steps as u64, &ids, arrays)
}

/// Reads what [`write_moments`] wrote.
pub(super) fn read_moments(path: &Path) -> Result<(usize, AllMoments)> {
    let (steps, ids, arrays) = read_arrays(path)?;
    if arrays.len() != 2 * ids.len() {
        let reason = format!("{} moments for {} parameters", arrays.len(), ids.len());
        return Err(Error::Format { path: path.into(), reason });
    }
    let mut arrays = arrays.into_iter();
    let mut next = || arrays.next().unwrap_or_default();
    let moments =
        ids.into_iter().map(|id| (id, Moments { first: next(), second: next() })).collect();
    Ok((steps as usize, moments))
}

/// The numbers of a tensor in single precision.
pub(super) fn numbers<const D: usize>(tensor: Tensor<D>) -> Vec<f32> {
    match tensor.dtype() {
        DType::F32 => tensor,
        _ => tensor.cast(DType::F32),
    }
    .into_data()
    .try_into_vec()
    .expect("the precision it was cast to")
}

struct Collector<'a> {
    gradients: GradientsParams,
    moments: &'a mut AllMoments,
    updates: Vec<Update>,
    /// Names of the modules around the parameter that is visited.
    path: Vec<String>,
}

impl Collector<'_> {
    fn place(&self) -> Place {
        let place = |name: &String| match name.as_str() {
            "decoders" => Some(Place::Decoder),
            "embeddings" => Some(Place::Embeddings),
            _ => None,
        };
        self.path.iter().find_map(place).unwrap_or(Place::Network)
    }
}

impl ModuleVisitor for Collector<'_> {
    fn enter_module(&mut self, name: &str, _container_type: &str) {
        self.path.push(name.to_string());
    }

    fn exit_module(&mut self, _name: &str, _container_type: &str) {
        self.path.pop();
    }

    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = self.gradients.remove::<D>(param.id) {
            self.updates.push(Update {
                id: param.id,
                shape: gradient.dims().to_vec(),
                place: self.place(),
                gradient: numbers(gradient),
                moments: self.moments.remove(&param.id.val()).unwrap_or_default(),
            });
        }
    }
}

struct Mapper {
    directions: BTreeMap<ParamId, Vec<f32>>,
    descent: Descent,
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
            descend(self.descent.kept, self.descent.step, &direction, &mut values);
            let weights = Tensor::from_data(TensorData::new(values, dims), &device);
            Tensor::from_inner(weights).set_require_grad(requires_gradient)
        })
    }
}
