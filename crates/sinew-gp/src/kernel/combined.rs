//! Sums and products of kernels.

use super::table::{from_formula, pull_back_from_formula};
use super::{Hyperparameter, Kernel, Request};
use crate::series::Series;

/// k₁(x, x′) + k₂(x, x′): independent functions added. Give summands amplitudes by [`super::Scaled`].
pub type Sum<const D: usize> = Combined<D, false>;
/// k₁(x, x′) k₂(x, x′), as a periodic kernel in one axis times a smooth one in another; its derivatives come from Taylor
/// series.
pub type Product<const D: usize> = Combined<D, true>;

/// Two kernels multiplied, or else added.
#[derive(Debug)]
pub struct Combined<const D: usize, const MULTIPLIED: bool> {
    kernels: [Box<dyn Kernel<D>>; 2],
}

impl<const D: usize, const MULTIPLIED: bool> Combined<D, MULTIPLIED> {
    /// Combination of two kernels; more by nesting.
    pub fn new(first: impl Kernel<D> + 'static, second: impl Kernel<D> + 'static) -> Self {
        Self { kernels: [Box::new(first), Box::new(second)] }
    }

    fn split(&self) -> usize {
        self.kernels[0].hyperparameters().len()
    }

    /// Derivatives asked of each of the two.
    fn requests<'a>(&self, request: &Request<'a, D>) -> [Request<'a, D>; 2] {
        let (first, second) = request.hyperparameters.split_at(self.split());
        [first, second].map(|hyperparameters| Request { hyperparameters, ..*request })
    }

    /// Whether its tables are the sums of the two kernels'. A stationary kernel beside one that is not may be asked for
    /// derivatives in x′, which it has no table of.
    fn is_sum_of_tables(&self) -> bool {
        !MULTIPLIED && Kernel::is_stationary(self)
    }
}

impl<const D: usize, const MULTIPLIED: bool> Kernel<D> for Combined<D, MULTIPLIED> {
    fn name(&self) -> String {
        let sign = if MULTIPLIED { "×" } else { "+" };
        format!("{} {sign} {}", self.kernels[0].name(), self.kernels[1].name())
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        self.kernels.iter().flat_map(|kernel| kernel.hyperparameters()).collect()
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        Box::new(Self { kernels: self.kernels.each_ref().map(|kernel| kernel.on_axes(axes)) })
    }

    fn formula(&self, hyperparameters: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        let (first, second) = hyperparameters.split_at(self.split());
        let first = self.kernels[0].formula(first, x, y);
        let second = self.kernels[1].formula(second, x, y);
        if MULTIPLIED { first * second } else { first + second }
    }

    fn smoothness(&self) -> Option<usize> {
        self.kernels.iter().filter_map(|kernel| kernel.smoothness()).min()
    }

    fn is_stationary(&self) -> bool {
        self.kernels.iter().all(|kernel| kernel.is_stationary())
    }

    fn derivatives(&self, request: &Request<'_, D>, table: &mut [f64]) {
        if !self.is_sum_of_tables() {
            return from_formula(self, request, table);
        }
        let [first, second] = self.requests(request);
        let mut other = vec![0.0; table.len()];
        self.kernels[0].derivatives(&first, table);
        self.kernels[1].derivatives(&second, &mut other);
        table.iter_mut().zip(other).for_each(|(sum, entry)| *sum += entry);
    }

    fn pull_back(&self, request: &Request<'_, D>, weights: &[f64], gradient: &mut [f64]) {
        if !self.is_sum_of_tables() {
            return pull_back_from_formula(self, request, weights, gradient);
        }
        let [first, second] = self.requests(request);
        let (to_first, to_second) = gradient.split_at_mut(self.split());
        self.kernels[0].pull_back(&first, weights, to_first);
        self.kernels[1].pull_back(&second, weights, to_second);
    }
}
