//! A plain network, the thesis' rival for volumes (§2.4.4.1): two hidden layers under tanh, squared errors, Adam.

use crate::program::cpu_seconds;
use nalgebra::DMatrix;
use ndarray::{ArrayView2, ShapeBuilder};
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};

/// Width of the hidden layers, samples in a step.
const WIDTH: usize = 128;
const BATCH: usize = 200;
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
            let rows = active.nrows();
            handed.push(active.insert_row(rows, 1.0));
            x = product(weights, &handed[index]);
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
            gradients.insert(0, product(&slope, &active.transpose()));
            let rows = weights.ncols() - 1;
            let below = product(&weights.columns(0, rows).transpose(), &slope);
            slope = below.zip_map(&active.rows(0, rows), |slope, a| slope * (1.0 - a * a));
        }
        gradients
    }

    fn error(&self, (x, y): &Samples) -> f32 {
        (self.predict(x) - y).norm_squared()
    }

    /// Trains a network for so many epochs at most: where it stops with each patience, which rise, and without any.
    pub(super) fn train(
        training: &Samples,
        validation: &Samples,
        patience: &[usize],
        epochs: usize,
        seed: u64,
    ) -> Vec<Stopped> {
        let (start, mut random) = (cpu_seconds(), ChaCha8Rng::seed_from_u64(seed));
        let mut last = Self::new(training.0.nrows(), &mut random);
        let mut moments: Vec<_> = last.0.iter().map(|w| [0.0, 0.0].map(|zero| w * zero)).collect();
        let mut order: Vec<usize> = (0..training.0.ncols()).collect();
        let (mut best, mut least, mut lowest, mut step) = (last.clone(), f32::INFINITY, 0, 0);
        let mut found: Vec<Stopped> = Vec::new();
        for epoch in 1..=epochs {
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
            let waits = patience.get(found.len()).copied().unwrap_or(epochs);
            if epoch - lowest >= waits || epoch == epochs {
                let ends = if epoch == epochs { patience.len() + 1 } else { found.len() + 1 };
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

/// Product by blocks for the vector instructions of the machine, which nalgebra has with its feature `std` alone.
fn product(a: &DMatrix<f32>, b: &DMatrix<f32>) -> DMatrix<f32> {
    fn view(m: &DMatrix<f32>) -> ArrayView2<'_, f32> {
        ArrayView2::from_shape(m.shape().f(), m.as_slice()).expect("entries column by column")
    }
    let product = view(a).dot(&view(b));
    DMatrix::from_iterator(a.nrows(), b.ncols(), product.t().iter().copied())
}
