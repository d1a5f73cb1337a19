//! A plain network, the thesis' rival for volumes (§2.4.4.1): two hidden layers under tanh, squared errors, Adam.

use crate::timing::cpu_seconds;
use nalgebra::DMatrix;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Width of the hidden layers, samples in a step, passes over all samples.
const WIDTH: usize = 128;
const BATCH: usize = 200;
pub(super) const EPOCHS: usize = 1000;
/// Adam's learning rate, shares of its moments that are kept, and what keeps it from dividing by zero (Kingma and Ba 2015).
const RATE: f32 = 1e-3;
const KEPT: [f32; 2] = [0.9, 0.999];
const EPSILON: f32 = 1e-8;

/// Weights of every layer, those of its bias in the last column.
#[derive(Clone, Debug)]
pub(super) struct Perceptron(Vec<DMatrix<f32>>);

/// Inputs in columns, and what is to be found for each, of mean zero and variance one.
pub(super) type Samples = (DMatrix<f32>, DMatrix<f32>);

/// End of a training that waits so many epochs for less error on what it validates with.
#[derive(Clone, Debug)]
pub(super) struct Stopped {
    pub epoch: usize,
    /// CPU time until then \[s\].
    pub cpu_s: f64,
    /// The weights with the least error until then, and the last ones.
    pub best: Perceptron,
    pub last: Perceptron,
}

fn with_ones(x: DMatrix<f32>) -> DMatrix<f32> {
    let rows = x.nrows();
    x.insert_row(rows, 1.0)
}

impl Perceptron {
    /// Uniform weights (Glorot and Bengio 2010).
    fn new(inputs: usize, random: &mut ChaCha8Rng) -> Self {
        let sizes = [inputs, WIDTH, WIDTH, 1];
        let layer = |pair: &[usize]| {
            let bound = (6.0 / (pair[0] + pair[1]) as f32).sqrt();
            DMatrix::from_fn(pair[1], pair[0] + 1, |_, _| {
                bound * (2.0 * random.random::<f32>() - 1.0)
            })
        };
        Self(sizes.windows(2).map(layer).collect())
    }

    /// Inputs of every layer, and the output of the last one.
    fn forward(&self, x: &DMatrix<f32>) -> (Vec<DMatrix<f32>>, DMatrix<f32>) {
        let (mut handed, mut x) = (Vec::new(), x.clone());
        for (index, weights) in self.0.iter().enumerate() {
            let active = if index == 0 { x } else { x.map(f32::tanh) };
            handed.push(with_ones(active));
            x = weights * &handed[index];
        }
        (handed, x)
    }

    pub(super) fn predict(&self, x: &DMatrix<f32>) -> DMatrix<f32> {
        self.forward(x).1
    }

    /// Gradient of half the mean squared error, by layer.
    fn gradients(&self, (x, y): &Samples) -> Vec<DMatrix<f32>> {
        let (handed, found) = self.forward(x);
        let (mut slope, mut gradients) = ((found - y) / x.ncols() as f32, Vec::new());
        for (weights, active) in self.0.iter().zip(&handed).rev() {
            gradients.insert(0, &slope * active.transpose());
            let rows = weights.ncols() - 1;
            let below = weights.columns(0, rows).transpose() * slope;
            slope = below.zip_map(&active.rows(0, rows), |slope, a| slope * (1.0 - a * a));
        }
        gradients
    }

    fn error(&self, (x, y): &Samples) -> f32 {
        (self.predict(x) - y).norm_squared()
    }

    /// Trains a network: where it stops with each patience, which rise, and without any.
    pub(super) fn train(
        training: &Samples,
        validation: &Samples,
        patience: &[usize],
        seed: u64,
    ) -> Vec<Stopped> {
        let (start, mut random) = (cpu_seconds(), ChaCha8Rng::seed_from_u64(seed));
        let mut last = Self::new(training.0.nrows(), &mut random);
        let mut moments: Vec<_> = last.0.iter().map(|w| [0.0, 0.0].map(|zero| w * zero)).collect();
        let mut order: Vec<usize> = (0..training.0.ncols()).collect();
        let (mut best, mut least, mut lowest, mut step) = (last.clone(), f32::INFINITY, 0, 0);
        let mut found: Vec<Stopped> = Vec::new();
        for epoch in 1..=EPOCHS {
            order.shuffle(&mut random);
            for batch in order.chunks(BATCH) {
                let columns = |of: &DMatrix<f32>| of.select_columns(batch);
                let gradients = last.gradients(&(columns(&training.0), columns(&training.1)));
                step += 1;
                last.adam(step, &gradients, &mut moments);
            }
            let error = last.error(validation);
            if error < least {
                (best, least, lowest) = (last.clone(), error, epoch);
            }
            let waits = patience.get(found.len()).copied().unwrap_or(EPOCHS);
            if epoch - lowest >= waits || epoch == EPOCHS {
                let ends = if epoch == EPOCHS { patience.len() + 1 } else { found.len() + 1 };
                let cpu_s = cpu_seconds() - start;
                let stopped = Stopped { epoch, cpu_s, best: best.clone(), last: last.clone() };
                found.resize(ends, stopped);
            }
        }
        found
    }

    fn adam(&mut self, step: i32, gradients: &[DMatrix<f32>], moments: &mut [[DMatrix<f32>; 2]]) {
        let [first, second] = KEPT.map(|kept| 1.0 / (1.0 - kept.powi(step)));
        for ((weights, gradient), [m, v]) in self.0.iter_mut().zip(gradients).zip(moments) {
            let moments = m.iter_mut().zip(v.iter_mut());
            for ((w, g), (m, v)) in weights.iter_mut().zip(gradient).zip(moments) {
                *m = KEPT[0] * *m + (1.0 - KEPT[0]) * g;
                *v = KEPT[1] * *v + (1.0 - KEPT[1]) * g * g;
                *w -= RATE * first * *m / ((second * *v).sqrt() + EPSILON);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(count: usize, seed: u64) -> Samples {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let x = DMatrix::from_fn(3, count, |_, _| 2.0 * random.random::<f32>() - 1.0);
        let y = DMatrix::from_fn(1, count, |_, k| 2.0 * x[(0, k)] * x[(1, k)] + x[(2, k)]);
        (x, y)
    }

    #[test]
    fn gradients_are_those_of_half_the_mean_squared_error() {
        let (mut network, data) =
            (Perceptron::new(3, &mut ChaCha8Rng::seed_from_u64(1)), samples(7, 2));
        let gradients = network.gradients(&data);
        // Central differences in single precision: 1e-2² of truncation, 1e-7 / 1e-2 of rounding.
        const STEP: f32 = 1e-2;
        for (layer, at) in [(0, (5, 1)), (0, (9, 3)), (1, (100, 7)), (1, (3, WIDTH)), (2, (0, 11))]
        {
            let mut error = |by: f32| {
                network.0[layer][at] += by;
                0.5 * network.error(&data) / 7.0
            };
            let difference = (error(STEP) - error(-2.0 * STEP)) / (2.0 * STEP);
            error(STEP);
            let gradient = gradients[layer][at];
            assert!((difference - gradient).abs() < 1e-4, "{layer} {at:?} {difference} {gradient}");
        }
    }

    #[test]
    fn a_network_learns_a_product_and_patience_stops_it_earlier() {
        let (training, validation) = (samples(200, 3), samples(50, 4));
        let found = Perceptron::train(&training, &validation, &[1, 20], 5);
        let epochs: Vec<_> = found.iter().map(|stopped| stopped.epoch).collect();
        assert!(
            epochs[0] < epochs[1] && epochs[1] <= epochs[2] && epochs[2] == EPOCHS,
            "{epochs:?}"
        );
        let errors = |of: fn(&Stopped) -> &Perceptron| -> Vec<f32> {
            found.iter().map(|stopped| of(stopped).error(&validation)).collect()
        };
        let [best, last] = [errors(|s| &s.best), errors(|s| &s.last)];
        assert!(best.iter().zip(&last).all(|(best, last)| best <= last), "{best:?} {last:?}");
        // Of a variance near 0.8; 5 % of the deviation are left.
        let share = best[2] / validation.1.norm_squared();
        assert!(share < 0.05f32.powi(2), "{share}");
        let again = Perceptron::train(&training, &validation, &[1, 20], 5);
        assert_eq!(again[2].last.0, found[2].last.0, "the same seed, the same weights");
    }
}
