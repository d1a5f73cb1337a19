//! A kernel times a variance.

use super::{Hyperparameter, Kernel, Measure, Request};
use crate::series::Series;

/// σ² k(x, x′), for summands of a [`super::Sum`]; a prior has an amplitude of its own already.
#[derive(Debug)]
pub struct Scaled<const D: usize> {
    kernel: Box<dyn Kernel<D>>,
}

impl<const D: usize> Scaled<D> {
    /// `kernel` with a standard deviation σ as its first hyperparameter.
    pub fn new(kernel: impl Kernel<D> + 'static) -> Self {
        Self { kernel: Box::new(kernel) }
    }
}

impl<const D: usize> Kernel<D> for Scaled<D> {
    fn name(&self) -> String {
        format!("scaled {}", self.kernel.name())
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        let sigma = Hyperparameter {
            name: "amplitude",
            measure: Measure::Number { lower: 1e-3, upper: 1e3 },
        };
        std::iter::once(sigma).chain(self.kernel.hyperparameters()).collect()
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        Box::new(Self { kernel: self.kernel.on_axes(axes) })
    }

    fn formula(&self, hyperparameters: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        hyperparameters[0].squared() * self.kernel.formula(&hyperparameters[1..], x, y)
    }

    fn smoothness(&self) -> Option<usize> {
        self.kernel.smoothness()
    }

    fn is_stationary(&self) -> bool {
        self.kernel.is_stationary()
    }

    fn derivatives(&self, request: &Request<'_, D>, table: &mut [f64]) {
        let (variance, inner) = split(request);
        self.kernel.derivatives(&inner, table);
        table.iter_mut().for_each(|entry| *entry *= variance);
    }

    fn pull_back(&self, request: &Request<'_, D>, weights: &[f64], gradient: &mut [f64]) {
        let (variance, inner) = split(request);
        let mut table = vec![0.0; weights.len()];
        self.derivatives(request, &mut table);
        gradient[0] += 2.0 * table.iter().zip(weights).map(|(t, w)| t * w).sum::<f64>();
        let scaled: Vec<f64> = weights.iter().map(|w| w * variance).collect();
        self.kernel.pull_back(&inner, &scaled, &mut gradient[1..]);
    }
}

/// σ², and what is asked of the kernel that it multiplies.
fn split<'a, const D: usize>(request: &Request<'a, D>) -> (f64, Request<'a, D>) {
    let hyperparameters = &request.hyperparameters[1..];
    (request.hyperparameters[0].powi(2), Request { hyperparameters, ..*request })
}
