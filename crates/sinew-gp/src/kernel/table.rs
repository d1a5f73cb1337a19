//! Tables of derivatives by Taylor series in the coordinates of a pair, for any formula.

use sinew_num::Series;

use super::{Kernel, Orders, Pairs};

/// Highest order asked for in each of the 2 D coordinates of a pair.
fn degrees<const D: usize>(orders: &[Orders<D>]) -> Vec<usize> {
    let most = |pick: &dyn Fn(&Orders<D>) -> usize| orders.iter().map(pick).max().unwrap_or(0);
    let first = (0..D).map(|d| most(&|o| o.first[d]));
    let second = (0..D).map(|d| most(&|o| o.second[d]));
    first.chain(second).collect()
}

/// Coordinates of a pair as variables, followed by further ones of degree one.
fn variables<const D: usize>(
    x: [f64; D],
    y: [f64; D],
    degrees: &[usize],
) -> ([Series; D], [Series; D]) {
    (
        std::array::from_fn(|d| Series::variable(x[d], d, degrees)),
        std::array::from_fn(|d| Series::variable(y[d], D + d, degrees)),
    )
}

/// [`Kernel::derivatives`] from the formula.
pub(super) fn by_series<K: Kernel<D> + ?Sized, const D: usize>(
    kernel: &K,
    hyperparameters: &[f64],
    pairs: &Pairs<'_, D>,
    orders: &[Orders<D>],
    table: &mut [f64],
) {
    let degrees = degrees(orders);
    let count = pairs.count();
    for lane in 0..count {
        let (x, y) = variables(pairs.point(lane), pairs.second, &degrees);
        let constants: Vec<Series> = hyperparameters.iter().map(|h| x[0].constant(*h)).collect();
        let value = kernel.formula(&constants, &x, &y) + x[0].constant(0.0);
        for (entry, order) in orders.iter().enumerate() {
            let order = [order.first.as_slice(), order.second.as_slice()].concat();
            table[entry * count + lane] = value.derivative(&order);
        }
    }
}

/// [`Kernel::pull_back`] from the formula, one hyperparameter at a time.
pub(super) fn pull_back_by_series<K: Kernel<D> + ?Sized, const D: usize>(
    kernel: &K,
    hyperparameters: &[f64],
    pairs: &Pairs<'_, D>,
    orders: &[Orders<D>],
    weights: &[f64],
    gradient: &mut [f64],
) {
    let mut degrees = degrees(orders);
    degrees.push(1);
    let count = pairs.count();
    for lane in 0..count {
        let (x, y) = variables(pairs.point(lane), pairs.second, &degrees);
        for (number, slope) in gradient.iter_mut().enumerate() {
            let numbers: Vec<Series> = hyperparameters
                .iter()
                .enumerate()
                .map(|(other, value)| match other == number {
                    true => Series::variable(*value, 2 * D, &degrees),
                    false => x[0].constant(*value),
                })
                .collect();
            let value = kernel.formula(&numbers, &x, &y) + x[0].constant(0.0);
            for (entry, order) in orders.iter().enumerate() {
                let order = [order.first.as_slice(), order.second.as_slice(), &[1]].concat();
                *slope += weights[entry * count + lane]
                    * value.derivative(&order)
                    * hyperparameters[number];
            }
        }
    }
}
