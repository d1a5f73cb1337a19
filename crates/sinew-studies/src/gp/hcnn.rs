//! A network with the boundary conditions built in (HCNN, 4.28), on an interval: u = m + Σ φₚ zₚ with mean and features of a
//! constrained prior, and a hidden layer of tanh units for each zₚ that is a function; the others are constants.

use crate::gp::deep::tanh;
use crate::program::standard_normal;
use anyhow::{Context, Result};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use sinew_gp::{Constraints, Field, Problem, Series, constraints};

/// Units of the hidden layer.
const WIDTH: usize = 16;
/// Loss below which nothing but rounding is left.
const SMALL: f64 = 1e-24;
/// Damping that no step is found with.
const MOST_DAMPING: f64 = 1e12;

/// A network and its training.
pub(crate) struct Network {
    mean: Field<1>,
    /// φₚ, and whether zₚ is a function.
    features: Vec<(Field<1>, bool)>,
    ends: [f64; 2],
    /// Factors of the equation's derivatives, by their order.
    equation: Vec<f64>,
    weights: Vec<f64>,
    /// Mean squared misfit of the equation.
    pub loss: f64,
    /// Evaluations of misfit and slopes, over all restarts.
    pub evaluations: usize,
}

/// ∂ᵏz at `s` in [−1, 1], its derivatives in the weights times `factor` added to `slopes`: of a unit output, bias and incoming
/// weight, last a constant.
fn latent(weights: &[f64], s: f64, k: usize, factor: f64, slopes: &mut [f64]) -> f64 {
    let constant = weights.len() - 1;
    let share = if k == 0 { 1.0 } else { 0.0 };
    slopes[constant] += share * factor;
    let mut sum = share * weights[constant];
    for (unit, own) in weights[..constant].chunks(3).zip(slopes.chunks_mut(3)) {
        let (output, w) = (unit[0], unit[2]);
        let (derivatives, power) = (tanh(unit[1] + w * s), w.powi(k as i32));
        let lowered = if k == 0 { 0.0 } else { k as f64 * w.powi(k as i32 - 1) };
        let (at, after) = (derivatives[k], derivatives[k + 1]);
        sum += output * power * at;
        own[0] += factor * power * at;
        own[1] += factor * output * power * after;
        own[2] += factor * output * (lowered * at + power * s * after);
    }
    sum
}

impl Network {
    /// Least squares at collocation points by the method of Levenberg and Marquardt, the best of several starts.
    pub(crate) fn train(
        problem: &Problem<1>,
        (places, load): (&[[f64; 1]], &[f64]),
        (restarts, iterations): (usize, usize),
        seed: u64,
    ) -> Result<Self> {
        let Constraints { mean, features } = constraints(problem)?;
        let features: Vec<_> =
            features.into_iter().map(|f| (f.factor, !f.axes.is_empty())).collect();
        let mut equation = vec![0.0; 3];
        for term in problem.equation().terms() {
            equation[term.derivative.orders[0]] += term.scale;
        }
        let ends = problem.domain().ends()[0];
        let count = features.iter().map(|(_, free)| if *free { 3 * WIDTH + 1 } else { 1 }).sum();
        let weights = vec![0.0; count];
        let mut network =
            Self { mean, features, ends, equation, weights, loss: f64::INFINITY, evaluations: 0 };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut best = (f64::INFINITY, Vec::new());
        for _ in 0..restarts {
            network.weights = network.random(&mut random);
            let loss = network.descend((places, load), iterations);
            if loss < best.0 {
                best = (loss, network.weights.clone());
            }
        }
        (network.loss, network.weights) = best;
        (!network.weights.is_empty()).then_some(network).context("no start has a finite loss")
    }

    /// Weights from the prior (4.30) with unit variances, the output weights' shared among the units.
    fn random(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let mut weights = Vec::new();
        for (_, free) in &self.features {
            for _ in 0..if *free { WIDTH } else { 0 } {
                weights.push(standard_normal(random) / (WIDTH as f64).sqrt());
                weights.extend([standard_normal(random), standard_normal(random)]);
            }
            weights.push(standard_normal(random));
        }
        weights
    }

    /// The derivative of u of an order at x with its derivatives in the weights, times a factor, added to `slopes`.
    fn derivative(&self, x: f64, order: usize, factor: f64, slopes: &mut [f64]) -> f64 {
        let [lower, upper] = self.ends;
        let stretch = 2.0 / (upper - lower);
        let s = (x - lower) * stretch - 1.0;
        let at = |field: &Field<1>| field.at(Series::variables([x], [order]));
        let mut sum = at(&self.mean).derivative(&[order]);
        let mut offset = 0;
        for (feature, free) in &self.features {
            let size = if *free { 3 * WIDTH + 1 } else { 1 };
            let (own, phi) = (offset..offset + size, at(feature));
            offset += size;
            let mut binomial = 1.0;
            for k in 0..=order {
                let outer = binomial * phi.derivative(&[order - k]) * stretch.powi(k as i32);
                let slopes = &mut slopes[own.clone()];
                sum += outer * latent(&self.weights[own.clone()], s, k, factor * outer, slopes);
                binomial *= (order - k) as f64 / (k + 1) as f64;
            }
        }
        factor * sum
    }

    /// Left-hand side of the equation at x, with its slopes in the weights.
    fn left(&self, x: f64, slopes: &mut [f64]) -> f64 {
        let factors = self.equation.iter().enumerate().filter(|(_, factor)| **factor != 0.0);
        factors.map(|(order, factor)| self.derivative(x, order, *factor, slopes)).sum()
    }

    fn misfit(&mut self, places: &[[f64; 1]], load: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        self.evaluations += 1;
        let scale = (places.len() as f64).sqrt().recip();
        let mut residual = DVector::zeros(places.len());
        let mut jacobian = DMatrix::zeros(places.len(), self.weights.len());
        let mut slopes = vec![0.0; self.weights.len()];
        for (row, ([x], f)) in places.iter().zip(load).enumerate() {
            slopes.fill(0.0);
            residual[row] = scale * (self.left(*x, &mut slopes) - f);
            slopes.iter().enumerate().for_each(|(k, slope)| jacobian[(row, k)] = scale * slope);
        }
        (residual, jacobian)
    }

    /// Moves to a minimum of the loss; its value.
    fn descend(&mut self, (places, load): (&[[f64; 1]], &[f64]), iterations: usize) -> f64 {
        let (mut residual, mut jacobian) = self.misfit(places, load);
        let mut damping = 1e-2;
        for _ in 0..iterations {
            let loss = residual.norm_squared();
            if loss < SMALL || damping > MOST_DAMPING {
                break;
            }
            // (JᵀJ + λI)⁻¹ Jᵀ r = Jᵀ (JJᵀ + λI)⁻¹ r: there are fewer points than weights.
            let count = residual.len();
            let normal =
                &jacobian * jacobian.transpose() + DMatrix::identity(count, count) * damping;
            let Some(factor) = normal.cholesky() else { break };
            let step = jacobian.tr_mul(&factor.solve(&residual));
            let before = self.weights.clone();
            self.weights.iter_mut().zip(step.iter()).for_each(|(w, step)| *w -= step);
            let (next, slopes) = self.misfit(places, load);
            if next.norm_squared() < loss {
                (residual, jacobian) = (next, slopes);
                damping *= 0.3;
            } else {
                self.weights = before;
                damping *= 4.0;
            }
        }
        residual.norm_squared()
    }

    pub(crate) fn values(&self, points: &[[f64; 1]]) -> Vec<f64> {
        let mut unused = vec![0.0; self.weights.len()];
        points.iter().map(|[x]| self.derivative(*x, 0, 1.0, &mut unused)).collect()
    }

    /// The equation's left-hand side at points.
    pub(crate) fn loads(&self, points: &[[f64; 1]]) -> Vec<f64> {
        let mut unused = vec![0.0; self.weights.len()];
        points.iter().map(|[x]| self.left(*x, &mut unused)).collect()
    }
}
