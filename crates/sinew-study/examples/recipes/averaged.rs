//! Exponential averages of the weights.

use std::collections::BTreeMap;
use std::path::Path;

use burn::module::{Module, ModuleMapper, ModuleVisitor, Param, ParamId};
use burn::optim::GradientsParams;
use burn::tensor::{Tensor, TensorData};
use sinew_gnn::{Emulator, Optimiser, OptimiserConfig, Result};

/// Another optimiser whose last step returns the average of the weights on the way.
pub struct Averaged {
    inner: Box<dyn Optimiser>,
    /// Share of the average that a step keeps.
    decay: f32,
    steps_left: usize,
    averages: BTreeMap<ParamId, Vec<f32>>,
}

impl Averaged {
    pub fn new(inner: &OptimiserConfig, decay: f32, steps: usize) -> Self {
        Self { inner: inner.build(), decay, steps_left: steps, averages: BTreeMap::new() }
    }
}

impl Optimiser for Averaged {
    fn step(
        &mut self,
        learning_rate: f64,
        emulator: Emulator,
        gradients: GradientsParams,
    ) -> Emulator {
        let emulator = self.inner.step(learning_rate, emulator, gradients);
        emulator.visit(&mut Accumulate { decay: self.decay, averages: &mut self.averages });
        self.steps_left = self.steps_left.saturating_sub(1);
        match self.steps_left {
            0 => emulator.map(&mut Replace { averages: &self.averages }),
            _ => emulator,
        }
    }

    fn save(&self, path: &Path) -> Result<()> {
        self.inner.save(path)
    }

    fn load(&mut self, path: &Path) -> Result<()> {
        self.inner.load(path)
    }
}

struct Accumulate<'a> {
    decay: f32,
    averages: &'a mut BTreeMap<ParamId, Vec<f32>>,
}

impl ModuleVisitor for Accumulate<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        let values: Vec<f32> = param.val().without_autodiff().into_data().iter::<f32>().collect();
        let average = self.averages.entry(param.id).or_insert_with(|| values.clone());
        for (average, value) in average.iter_mut().zip(values) {
            *average = self.decay * *average + (1.0 - self.decay) * value;
        }
    }
}

struct Replace<'a> {
    averages: &'a BTreeMap<ParamId, Vec<f32>>,
}

impl ModuleMapper for Replace<'_> {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let Some(average) = self.averages.get(&param.id) else { return param };
        param.map(|weights| {
            let requires_gradient = weights.is_require_grad();
            let (device, dims) = (weights.device().without_autodiff(), weights.dims());
            let weights = Tensor::from_data(TensorData::new(average.clone(), dims), &device);
            Tensor::from_inner(weights).set_require_grad(requires_gradient)
        })
    }
}
