//! A kernel times a variance.

use sinew_num::Series;

use super::{Hyperparameter, Kernel, Measure, Orders, Pairs};

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

    fn formula(&self, parameters: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        parameters[0].squared() * self.kernel.formula(&parameters[1..], x, y)
    }

    fn smoothness(&self) -> Option<usize> {
        self.kernel.smoothness()
    }

    fn is_stationary(&self) -> bool {
        self.kernel.is_stationary()
    }

    fn derivatives(
        &self,
        parameters: &[f64],
        pairs: &Pairs<'_, D>,
        orders: &[Orders<D>],
        table: &mut [f64],
    ) {
        self.kernel.derivatives(&parameters[1..], pairs, orders, table);
        table.iter_mut().for_each(|entry| *entry *= parameters[0] * parameters[0]);
    }

    fn pull_back(
        &self,
        parameters: &[f64],
        pairs: &Pairs<'_, D>,
        orders: &[Orders<D>],
        weights: &[f64],
        gradient: &mut [f64],
    ) {
        let mut table = vec![0.0; weights.len()];
        self.derivatives(parameters, pairs, orders, &mut table);
        gradient[0] += 2.0 * table.iter().zip(weights).map(|(t, w)| t * w).sum::<f64>();
        let scaled: Vec<f64> = weights.iter().map(|w| w * parameters[0] * parameters[0]).collect();
        self.kernel.pull_back(&parameters[1..], pairs, orders, &scaled, &mut gradient[1..]);
    }
}
