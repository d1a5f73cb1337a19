//! Sums and products of kernels.

use super::table::{from_formula, pull_back_from_formula};
use super::{Hyperparameter, Kernel, Orders, Request};
use sinew_num::Series;

/// k₁(x, x′) + k₂(x, x′): independent functions added. Give summands amplitudes by [`super::Scaled`].
pub type Sum<const D: usize> = Combined<D, false>;
/// k₁(x, x′) k₂(x, x′), as a periodic kernel in one axis times a smooth one in another.
pub type Product<const D: usize> = Combined<D, true>;

/// Two kernels multiplied, or else added.
#[derive(Debug)]
pub struct Combined<const D: usize, const MULTIPLIED: bool> {
    kernels: [Box<dyn Kernel<D>>; 2],
}

/// One summand of a derivative: factor × entry of the first kernel's table × entry of the second's,
/// or where there is none of one of them, one in its place.
struct Term {
    entry: usize,
    factor: f64,
    reads: [Option<usize>; 2],
}

impl<const D: usize, const MULTIPLIED: bool> Combined<D, MULTIPLIED> {
    /// Of two kernels; more by nesting.
    pub fn new(first: impl Kernel<D> + 'static, second: impl Kernel<D> + 'static) -> Self {
        Self { kernels: [Box::new(first), Box::new(second)] }
    }

    fn split(&self) -> usize {
        self.kernels[0].hyperparameters().len()
    }

    /// All derivatives that both kernels' tables need, and how they combine.
    fn terms(orders: &[Orders<D>]) -> (Vec<Orders<D>>, Vec<Term>) {
        if MULTIPLIED {
            return leibniz(orders);
        }
        let term = |entry, reads| Term { entry, factor: 1.0, reads };
        let both = |entry| [term(entry, [Some(entry), None]), term(entry, [None, Some(entry)])];
        (orders.to_vec(), (0..orders.len()).flat_map(both).collect())
    }

    /// What is asked of each of the two.
    fn requests<'a>(
        &self,
        request: &Request<'a, D>,
        orders: &'a [Orders<D>],
    ) -> [Request<'a, D>; 2] {
        let (first, second) = request.hyperparameters.split_at(self.split());
        [first, second].map(|hyperparameters| Request { hyperparameters, orders, ..*request })
    }

    fn tables(&self, requests: &[Request<'_, D>; 2]) -> [Vec<f64>; 2] {
        std::array::from_fn(|number| {
            let request = &requests[number];
            let mut table = vec![0.0; request.orders.len() * request.count()];
            self.kernels[number].derivatives(request, &mut table);
            table
        })
    }
}

/// Leibniz' rule.
fn leibniz<const D: usize>(orders: &[Orders<D>]) -> (Vec<Orders<D>>, Vec<Term>) {
    let mut needed: Vec<Orders<D>> = Vec::new();
    let mut position = |orders: [usize; D]| {
        let order = Orders { first: orders, second: [0; D] };
        needed.iter().position(|known| *known == order).unwrap_or_else(|| {
            needed.push(order);
            needed.len() - 1
        })
    };
    let mut terms = Vec::new();
    for (entry, order) in orders.iter().enumerate() {
        let total: usize = order.first.iter().map(|n| n + 1).product();
        for number in 0..total {
            let mut rest = number;
            let mut factor = 1.0;
            let share: [usize; D] = std::array::from_fn(|d| {
                let n = order.first[d];
                let k = rest % (n + 1);
                rest /= n + 1;
                factor *= choose(n, k);
                k
            });
            let first = position(share);
            let second = position(std::array::from_fn(|d| order.first[d] - share[d]));
            terms.push(Term { entry, factor, reads: [Some(first), Some(second)] });
        }
    }
    (needed, terms)
}

/// Binomial coefficient.
pub(crate) fn choose(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product::<f64>().round()
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
        // A stationary kernel beside one that is not may be asked for derivatives in x′.
        if !self.is_stationary() {
            return from_formula(self, request, table);
        }
        let (needed, terms) = Self::terms(request.orders);
        let tables = self.tables(&self.requests(request, &needed));
        table.fill(0.0);
        let count = request.count();
        for Term { entry, factor, reads } in terms {
            for lane in 0..count {
                let at = |number: usize| {
                    reads[number].map_or(1.0, |read| tables[number][read * count + lane])
                };
                table[entry * count + lane] += factor * at(0) * at(1);
            }
        }
    }

    fn pull_back(&self, request: &Request<'_, D>, weights: &[f64], gradient: &mut [f64]) {
        if !self.is_stationary() {
            return pull_back_from_formula(self, request, weights, gradient);
        }
        let (needed, terms) = Self::terms(request.orders);
        let requests = self.requests(request, &needed);
        let tables = self.tables(&requests);
        let mut slopes = tables.each_ref().map(|table| vec![0.0; table.len()]);
        let count = request.count();
        for Term { entry, factor, reads } in terms {
            for lane in 0..count {
                let weight = factor * weights[entry * count + lane];
                for number in [0, 1] {
                    let Some(read) = reads[number] else { continue };
                    let other =
                        reads[1 - number].map(|read| tables[1 - number][read * count + lane]);
                    slopes[number][read * count + lane] += weight * other.unwrap_or(1.0);
                }
            }
        }
        let (first, second) = gradient.split_at_mut(self.split());
        for (number, gradient) in [first, second].into_iter().enumerate() {
            self.kernels[number].pull_back(&requests[number], &slopes[number], gradient);
        }
    }
}
