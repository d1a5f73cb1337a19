//! Products of kernels.

use sinew_num::Series;

use super::table::{from_formula, pull_back_from_formula};
use super::{Hyperparameter, Kernel, Orders, Pairs};

/// k₁(x, x′) k₂(x, x′), as a periodic kernel in one axis times a smooth one in another.
#[derive(Debug)]
pub struct Product<const D: usize> {
    kernels: [Box<dyn Kernel<D>>; 2],
}

impl<const D: usize> Product<D> {
    /// Of two kernels; more by nesting.
    pub fn new(first: impl Kernel<D> + 'static, second: impl Kernel<D> + 'static) -> Self {
        Self { kernels: [Box::new(first), Box::new(second)] }
    }

    fn split(&self) -> usize {
        self.kernels[0].hyperparameters().len()
    }
}

/// One term of Leibniz' rule: binomial × entry of the first factor × entry of the second.
struct Term {
    entry: usize,
    binomial: f64,
    first: usize,
    second: usize,
}

/// All derivatives that the factors need, and how they combine.
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
            let mut binomial = 1.0;
            let share: [usize; D] = std::array::from_fn(|d| {
                let n = order.first[d];
                let k = rest % (n + 1);
                rest /= n + 1;
                binomial *= choose(n, k);
                k
            });
            let first = position(share);
            let second = position(std::array::from_fn(|d| order.first[d] - share[d]));
            terms.push(Term { entry, binomial, first, second });
        }
    }
    (needed, terms)
}

/// Binomial coefficient.
pub(crate) fn choose(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product::<f64>().round()
}

impl<const D: usize> Kernel<D> for Product<D> {
    fn name(&self) -> String {
        format!("{} × {}", self.kernels[0].name(), self.kernels[1].name())
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        self.kernels.iter().flat_map(|kernel| kernel.hyperparameters()).collect()
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        Box::new(Self { kernels: self.kernels.each_ref().map(|kernel| kernel.on_axes(axes)) })
    }

    fn formula(&self, parameters: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        let (first, second) = parameters.split_at(self.split());
        self.kernels[0].formula(first, x, y) * self.kernels[1].formula(second, x, y)
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
        if !self.is_stationary() {
            return from_formula(self, parameters, pairs, orders, table);
        }
        let (needed, terms) = leibniz(orders);
        let [first, second] = self.factor_tables(parameters, pairs, &needed);
        table.fill(0.0);
        let count = pairs.count();
        for term in terms {
            for lane in 0..count {
                table[term.entry * count + lane] += term.binomial
                    * first[term.first * count + lane]
                    * second[term.second * count + lane];
            }
        }
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
        let (needed, terms) = leibniz(orders);
        let [first, second] = self.factor_tables(parameters, pairs, &needed);
        let mut slopes = [vec![0.0; first.len()], vec![0.0; second.len()]];
        let count = pairs.count();
        for term in terms {
            for lane in 0..count {
                let weight = term.binomial * weights[term.entry * count + lane];
                let (a, b) = (term.first * count + lane, term.second * count + lane);
                slopes[0][a] += weight * second[b];
                slopes[1][b] += weight * first[a];
            }
        }
        let (left, right) = parameters.split_at(self.split());
        let (left_gradient, right_gradient) = gradient.split_at_mut(self.split());
        self.kernels[0].pull_back(left, pairs, &needed, &slopes[0], left_gradient);
        self.kernels[1].pull_back(right, pairs, &needed, &slopes[1], right_gradient);
    }
}

impl<const D: usize> Product<D> {
    fn factor_tables(
        &self,
        parameters: &[f64],
        pairs: &Pairs<'_, D>,
        orders: &[Orders<D>],
    ) -> [Vec<f64>; 2] {
        let (first, second) = parameters.split_at(self.split());
        let size = orders.len() * pairs.count();
        let mut tables = [vec![0.0; size], vec![0.0; size]];
        self.kernels[0].derivatives(first, pairs, orders, &mut tables[0]);
        self.kernels[1].derivatives(second, pairs, orders, &mut tables[1]);
        tables
    }
}
