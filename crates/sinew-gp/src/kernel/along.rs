//! A kernel along one direction in the plane of the first two axes.

use sinew_num::Series;

use super::{Hyperparameter, Kernel, MOST_PAIRS, Orders, Pairs};
use crate::operator::MOST_DERIVATIVES;

/// k(τ·x, τ·x′): covariances of functions that change along τ only, as traces on an edge, and
/// along the axes beyond the second.
#[derive(Debug)]
pub(crate) struct Along<const D: usize> {
    /// A function of the first axis and those beyond the second.
    kernel: Box<dyn Kernel<D>>,
    direction: [f64; 2],
}

impl<const D: usize> Along<D> {
    /// `kernel` as a function of the position along `direction` and of `axes` beyond the second.
    pub fn new(kernel: &dyn Kernel<D>, direction: [f64; 2], axes: &[usize]) -> Self {
        let others = axes.iter().copied().filter(|axis| *axis >= 2);
        let own: Vec<usize> = std::iter::once(0).chain(others).collect();
        Self { kernel: kernel.on_axes(&own), direction }
    }

    /// Orders of the inner kernel, and the factors that the chain rule puts in front.
    fn inner(&self, orders: &[Orders<D>]) -> (Vec<Orders<D>>, Vec<f64>) {
        let [tx, ty] = self.direction;
        let gathered = |n: [usize; D]| {
            let mut inner = n;
            (inner[0], inner[1]) = (n[0] + n[1], 0);
            (inner, tx.powi(n[0] as i32) * ty.powi(n[1] as i32))
        };
        orders
            .iter()
            .map(|order| {
                let (first, a) = gathered(order.first);
                let (second, b) = gathered(order.second);
                (Orders { first, second }, a * b)
            })
            .unzip()
    }

    /// Whether the inner kernel has closed forms for so many derivatives along one axis.
    fn is_within_reach(orders: &[Orders<D>]) -> bool {
        orders.iter().all(|order| order.first[0] + order.second[0] <= 2 * MOST_DERIVATIVES)
    }

    fn project(&self, pairs: &Pairs<'_, D>, positions: &mut [f64; MOST_PAIRS]) -> [f64; D] {
        let [tx, ty] = self.direction;
        for (position, (x, y)) in
            positions.iter_mut().zip(pairs.first[0].iter().zip(pairs.first[1]))
        {
            *position = tx * x + ty * y;
        }
        let mut second = pairs.second;
        second[0] = tx * pairs.second[0] + ty * pairs.second[1];
        second
    }
}

impl<const D: usize> Kernel<D> for Along<D> {
    fn name(&self) -> String {
        format!("{} along an edge", self.kernel.name())
    }

    fn hyperparameters(&self) -> Vec<Hyperparameter> {
        self.kernel.hyperparameters()
    }

    fn on_axes(&self, axes: &[usize]) -> Box<dyn Kernel<D>> {
        Box::new(Self::new(&*self.kernel, self.direction, axes))
    }

    fn formula(&self, parameters: &[Series], x: &[Series; D], y: &[Series; D]) -> Series {
        let [tx, ty] = self.direction;
        let projected = |x: &[Series; D]| {
            let mut projected = x.clone();
            projected[0] = &x[0] * tx + &x[1] * ty;
            projected
        };
        self.kernel.formula(parameters, &projected(x), &projected(y))
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
        let (inner, factors) = self.inner(orders);
        if !Self::is_within_reach(&inner) {
            return super::table::from_formula(self, parameters, pairs, orders, table);
        }
        let mut positions = [0.0; MOST_PAIRS];
        let second = self.project(pairs, &mut positions);
        let mut first = pairs.first;
        first[0] = &positions[..pairs.count()];
        self.kernel.derivatives(parameters, &Pairs { first, second }, &inner, table);
        for (row, factor) in table.chunks_mut(pairs.count()).zip(factors) {
            row.iter_mut().for_each(|entry| *entry *= factor);
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
        let (inner, factors) = self.inner(orders);
        if !Self::is_within_reach(&inner) {
            return super::table::pull_back_from_formula(
                self, parameters, pairs, orders, weights, gradient,
            );
        }
        let mut positions = [0.0; MOST_PAIRS];
        let second = self.project(pairs, &mut positions);
        let mut first = pairs.first;
        first[0] = &positions[..pairs.count()];
        let mut scaled = weights.to_vec();
        for (row, factor) in scaled.chunks_mut(pairs.count()).zip(factors) {
            row.iter_mut().for_each(|weight| *weight *= factor);
        }
        self.kernel.pull_back(parameters, &Pairs { first, second }, &inner, &scaled, gradient);
    }
}
