//! Sums of kernels.

use sinew_num::Series;

use super::table::{from_formula, pull_back_from_formula};
use super::{Hyperparameter, Kernel, Orders, Pairs};

/// k₁(x, x′) + k₂(x, x′): independent functions added. Give summands amplitudes by [`super::Scaled`].
#[derive(Debug)]
pub struct Sum<const D: usize> {
    kernels: [Box<dyn Kernel<D>>; 2],
}

impl<const D: usize> Sum<D> {
    /// Of two kernels; more by nesting.
    pub fn new(first: impl Kernel<D> + 'static, second: impl Kernel<D> + 'static) -> Self {
        Self { kernels: [Box::new(first), Box::new(second)] }
    }
}

impl<const D: usize> Kernel<D> for Sum<D> {
    fn name(&self) -> String {
        format!("{} + {}", self.kernels[0].name(), self.kernels[1].name())
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        self.kernels.iter().flat_map(|kernel| kernel.hyperparameters()).collect()
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        Box::new(Self { kernels: self.kernels.each_ref().map(|kernel| kernel.on_axes(axes)) })
    }

    fn formula(&self, parameters: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        let (first, second) = parameters.split_at(self.kernels[0].hyperparameters().len());
        self.kernels[0].formula(first, x, y) + self.kernels[1].formula(second, x, y)
    }

    fn smoothness(&self) -> Option<usize> {
        self.kernels.iter().filter_map(|kernel| kernel.smoothness()).min()
    }

    fn is_stationary(&self) -> bool {
        self.kernels.iter().all(|kernel| kernel.is_stationary())
    }

    fn derivatives(
        &self,
        parameters: &[f64],
        pairs: &Pairs<'_, D>,
        orders: &[Orders<D>],
        table: &mut [f64],
    ) {
        // A stationary summand of a sum that is not may be asked for derivatives in x′.
        if !self.is_stationary() {
            return from_formula(self, parameters, pairs, orders, table);
        }
        let (first, second) = parameters.split_at(self.kernels[0].hyperparameters().len());
        self.kernels[0].derivatives(first, pairs, orders, table);
        let mut other = vec![0.0; table.len()];
        self.kernels[1].derivatives(second, pairs, orders, &mut other);
        table.iter_mut().zip(&other).for_each(|(sum, term)| *sum += term);
    }

    fn pull_back(
        &self,
        parameters: &[f64],
        pairs: &Pairs<'_, D>,
        orders: &[Orders<D>],
        weights: &[f64],
        gradient: &mut [f64],
    ) {
        if !self.is_stationary() {
            return pull_back_from_formula(self, parameters, pairs, orders, weights, gradient);
        }
        let split = self.kernels[0].hyperparameters().len();
        let (first, second) = parameters.split_at(split);
        let (slopes, others) = gradient.split_at_mut(split);
        self.kernels[0].pull_back(first, pairs, orders, weights, slopes);
        self.kernels[1].pull_back(second, pairs, orders, weights, others);
    }
}
