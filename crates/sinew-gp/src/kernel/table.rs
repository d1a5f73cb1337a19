//! Tables of derivatives of any formula, by Taylor series in the coordinates of a pair.

use super::{Kernel, Orders, Request};
use crate::series::Series;

/// k of single pairs as series in their 2 D coordinates, of the degrees that are asked for.
struct Expansion<'a, K: ?Sized, const D: usize> {
    kernel: &'a K,
    request: &'a Request<'a, D>,
    /// Orders in the coordinates, then in a hyperparameter.
    degrees: Vec<usize>,
}

impl<'a, K: Kernel<D> + ?Sized, const D: usize> Expansion<'a, K, D> {
    fn new(kernel: &'a K, request: &'a Request<'a, D>) -> Self {
        let most = |pick: &dyn Fn(&Orders<D>) -> usize| request.orders.iter().map(pick).max();
        let first = (0..D).map(|d| most(&|o| o.first[d]));
        let second = (0..D).map(|d| most(&|o| o.second[d]));
        let degrees = first.chain(second).map(Option::unwrap_or_default).collect();
        Self { kernel, request, degrees }
    }

    /// Variables of pair `lane`; the hyperparameter `varied` is the last variable, the others are numbers.
    fn at(&self, lane: usize, varied: Option<usize>) -> Series {
        let variable = |value, number| Series::variable(value, number, &self.degrees);
        let first = self.request.point(lane);
        let x: [Series; D] = std::array::from_fn(|d| variable(first[d], d));
        let y = std::array::from_fn(|d| variable(self.request.second[d], D + d));
        let numbered = self.request.hyperparameters.iter().enumerate();
        let hyperparameters: Vec<Series> = numbered
            .map(|(number, value)| match varied == Some(number) {
                true => variable(*value, 2 * D),
                false => Series::number(*value),
            })
            .collect();
        self.kernel.formula(&hyperparameters, &x, &y) + x[0].constant(0.0)
    }
}

/// [`Kernel::derivatives`] from the formula.
pub(super) fn from_formula<K: Kernel<D> + ?Sized, const D: usize>(
    kernel: &K,
    request: &Request<'_, D>,
    table: &mut [f64],
) {
    let expansion = Expansion::new(kernel, request);
    let count = request.count();
    for lane in 0..count {
        let value = expansion.at(lane, None);
        for (entry, order) in request.orders.iter().enumerate() {
            let order = [order.first, order.second];
            table[entry * count + lane] = value.derivative(order.as_flattened());
        }
    }
}

/// [`Kernel::pull_back`] from the formula, one hyperparameter at a time.
pub(super) fn pull_back_from_formula<K: Kernel<D> + ?Sized, const D: usize>(
    kernel: &K,
    request: &Request<'_, D>,
    weights: &[f64],
    gradient: &mut [f64],
) {
    let mut expansion = Expansion::new(kernel, request);
    expansion.degrees.push(1);
    let count = request.count();
    for lane in 0..count {
        for (number, slope) in gradient.iter_mut().enumerate() {
            let value = expansion.at(lane, Some(number));
            for (entry, order) in request.orders.iter().enumerate() {
                let order = [&order.first[..], &order.second, &[1]].concat();
                *slope += weights[entry * count + lane]
                    * value.derivative(&order)
                    * request.hyperparameters[number];
            }
        }
    }
}
