//! Clipping by the norm of all gradients together.

use burn::module::{Module, ModuleVisitor, Param};
use burn::optim::GradientsParams;
use burn::tensor::Tensor;

use crate::emulator::Emulator;

/// Scales all gradients so that their common Euclidean norm is at most `limit`; returns the norm
/// before. Summed in double precision in the order of the module, so that it is reproducible.
pub(crate) fn clip_global_norm(
    emulator: &Emulator,
    gradients: GradientsParams,
    limit: Option<f64>,
) -> (GradientsParams, f64) {
    let mut norm = SquaredNorm { gradients: &gradients, sum: 0.0 };
    emulator.visit(&mut norm);
    let norm = norm.sum.sqrt();
    match limit {
        Some(limit) if norm > limit => {
            let mut scale = Scale { gradients, factor: limit / norm };
            emulator.visit(&mut scale);
            (scale.gradients, norm)
        }
        _ => (gradients, norm),
    }
}

struct SquaredNorm<'a> {
    gradients: &'a GradientsParams,
    sum: f64,
}

impl ModuleVisitor for SquaredNorm<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = self.gradients.get::<D>(param.id) {
            let data = gradient.into_data();
            self.sum += match data.as_slice::<f32>() {
                Ok(values) => squared_norm(values),
                Err(_) => data.iter::<f64>().map(|value| value * value).sum(),
            };
        }
    }
}

/// In interleaved partial sums, which the compiler turns into vectors.
fn squared_norm(values: &[f32]) -> f64 {
    let mut lanes = [0.0; 8];
    for chunk in values.chunks(lanes.len()) {
        for (lane, value) in lanes.iter_mut().zip(chunk) {
            *lane += f64::from(*value) * f64::from(*value);
        }
    }
    lanes.iter().sum()
}

struct Scale {
    gradients: GradientsParams,
    factor: f64,
}

impl ModuleVisitor for Scale {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = self.gradients.remove::<D>(param.id) {
            self.gradients.register(param.id, gradient * self.factor);
        }
    }
}
