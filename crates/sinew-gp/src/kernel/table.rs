//! Tables of derivatives of kernels: of any formula by Taylor series in the coordinates of a pair.

use super::Request;
use crate::series::Series;

impl<const D: usize> Request<'_, D> {
    /// Derivatives of k for each pair: entry `e` of the request's orders fills `table[e · count ..]`.
    pub(crate) fn derivatives(&self, table: &mut [f64]) {
        match self.kernel.as_squared_exponential() {
            Some(closed) => closed.derivatives(self, table),
            None => self.expand(None, |entry, value| table[entry] = value),
        }
    }

    /// [`Request::derivatives`] into `table`, then adds to `gradient` the derivatives of Σ weight · table in the logarithm of each
    /// hyperparameter, for the weights that `weigh` makes of the table, in memory of the same size.
    pub(crate) fn derivatives_and_pull_back(
        &self,
        [table, weights]: [&mut [f64]; 2],
        weigh: &mut dyn FnMut(&[f64], &mut [f64]),
        gradient: &mut [f64],
    ) {
        if let Some(closed) = self.kernel.as_squared_exponential() {
            return closed.derivatives_and_pull_back(self, [table, weights], weigh, gradient);
        }
        self.derivatives(table);
        weigh(table, weights);
        for (number, slope) in gradient.iter_mut().enumerate() {
            let value = self.hyperparameters[number];
            self.expand(Some(number), |entry, d| *slope += weights[entry] * d * value);
        }
    }

    /// Derivatives of k for each entry of the table, from a series in the 2 D coordinates of each pair; in the hyperparameter
    /// `varied` the first one, too.
    fn expand(&self, varied: Option<usize>, mut visit: impl FnMut(usize, f64)) {
        let further: &[usize] = if varied.is_some() { &[1] } else { &[] };
        let orders = self.orders.iter();
        let orders: Vec<Vec<usize>> =
            orders.map(|order| [&order.first, &order.second, further].concat()).collect();
        let most = |d: usize| orders.iter().map(|order| order[d]).max().unwrap_or_default();
        let degrees: Vec<usize> = (0..2 * D + further.len()).map(most).collect();
        let variable = |value, number| Series::variable(value, number, &degrees);
        let count = self.count();
        for lane in 0..count {
            let x: [Series; D] = std::array::from_fn(|d| variable(self.first[d][lane], d));
            let y = std::array::from_fn(|d| variable(self.second[d], D + d));
            let of = |(number, value): (usize, &f64)| match varied == Some(number) {
                true => variable(*value, 2 * D),
                false => Series::number(*value),
            };
            let known: Vec<Series> = self.hyperparameters.iter().enumerate().map(of).collect();
            let value = self.kernel.formula(&known, &x, &y) + x[0].constant(0.0);
            for (entry, order) in orders.iter().enumerate() {
                visit(entry * count + lane, value.derivative(order));
            }
        }
    }
}
