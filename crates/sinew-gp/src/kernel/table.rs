//! Tables of derivatives of kernels: of any formula by Taylor series in the coordinates of a pair.

use super::{Kernel, Orders, Request};
use crate::series::Series;

/// k of single pairs as series in their 2 D coordinates, of the degrees that are asked for.
struct Expansion<'a, const D: usize> {
    kernel: &'a dyn Kernel<D>,
    request: &'a Request<'a, D>,
    /// Orders in the coordinates, then in a hyperparameter.
    degrees: Vec<usize>,
}

impl<'a, const D: usize> Expansion<'a, D> {
    fn new(kernel: &'a dyn Kernel<D>, request: &'a Request<'a, D>) -> Self {
        let most = |pick: &dyn Fn(&Orders<D>) -> usize| request.orders.iter().map(pick).max();
        let first = (0..D).map(|d| most(&|o| o.first[d]));
        let second = (0..D).map(|d| most(&|o| o.second[d]));
        let degrees = first.chain(second).map(Option::unwrap_or_default).collect();
        Self { kernel, request, degrees }
    }

    /// Variables of pair `lane`; the hyperparameter `varied` is the last variable, the others are numbers.
    fn at(&self, lane: usize, varied: Option<usize>) -> Series {
        let variable = |value, number| Series::variable(value, number, &self.degrees);
        let first = self.request.first.map(|axis| axis[lane]);
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

/// Derivatives of k for each pair: entry `e` of the request's orders fills `table[e · count ..]`.
pub(crate) fn derivatives<const D: usize>(
    kernel: &dyn Kernel<D>,
    request: &Request<'_, D>,
    table: &mut [f64],
) {
    match kernel.as_squared_exponential() {
        Some(closed) => closed.derivatives(request, table),
        None => from_formula(kernel, request, table),
    }
}

/// [`derivatives`] into `table`, then adds to `gradient` the derivatives of Σ weight · table in the logarithm of each
/// hyperparameter, for the weights that `weigh` makes of the table, in memory of the same size.
pub(crate) fn derivatives_and_pull_back<const D: usize>(
    kernel: &dyn Kernel<D>,
    request: &Request<'_, D>,
    [table, weights]: [&mut [f64]; 2],
    weigh: &mut dyn FnMut(&[f64], &mut [f64]),
    gradient: &mut [f64],
) {
    if let Some(closed) = kernel.as_squared_exponential() {
        return closed.derivatives_and_pull_back(request, [table, weights], weigh, gradient);
    }
    from_formula(kernel, request, table);
    weigh(table, weights);
    pull_back_from_formula(kernel, request, weights, gradient);
}

/// [`derivatives`] from the formula.
pub(super) fn from_formula<const D: usize>(
    kernel: &dyn Kernel<D>,
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

/// Its gradient, one hyperparameter at a time.
fn pull_back_from_formula<const D: usize>(
    kernel: &dyn Kernel<D>,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::SquaredExponential;

    #[test]
    fn the_closed_form_is_that_of_the_formula() {
        const COUNT: usize = 13;
        let axes: [Vec<f64>; 2] =
            [0.7, 1.9].map(|f| (0..COUNT).map(|k| (f * k as f64).sin()).collect());
        let order = |a, b| Orders { first: [a, b], second: [0, 0] };
        let orders: Vec<Orders<2>> =
            (0..25).map(|k| order(k % 5, k / 5)).filter(|o| o.first[1] != 3).collect();
        let request = Request {
            hyperparameters: &[0.6, 0.8],
            first: axes.each_ref().map(Vec::as_slice),
            second: [axes[0][4], axes[1][4]],
            orders: &orders,
        };
        let kernel = SquaredExponential::new();
        let sizes = orders.len() * COUNT;
        let weight = |k: usize| ((k * 7 + 3) % 11) as f64 / 11.0 - 0.4;
        let given: Vec<f64> = (0..sizes).map(weight).collect();
        let (mut table, mut weights, mut gradient) = (vec![0.0; sizes], vec![0.0; sizes], [0.0; 2]);
        let mut weigh = |_: &[f64], weights: &mut [f64]| weights.copy_from_slice(&given);
        let memory = [&mut table[..], &mut weights[..]];
        derivatives_and_pull_back::<2>(&kernel, &request, memory, &mut weigh, &mut gradient);
        let (mut again, mut series, mut expected) = (table.clone(), table.clone(), [0.0; 2]);
        derivatives::<2>(&kernel, &request, &mut again);
        from_formula::<2>(&kernel, &request, &mut series);
        pull_back_from_formula::<2>(&kernel, &request, &given, &mut expected);
        assert_eq!(table, again);
        for (rows, rows_of_series) in table.chunks(COUNT).zip(series.chunks(COUNT)) {
            let scale = rows_of_series.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            for (a, b) in rows.iter().zip(rows_of_series) {
                // Some thirty roundings of terms as large as the largest entry.
                assert!((a - b).abs() < 1e-11 * scale, "{a} {b}");
            }
        }
        for (a, b) in gradient.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-11 * b.abs(), "{a} {b}");
        }
    }
}
