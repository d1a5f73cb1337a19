//! Neural networks with the boundary conditions built in (HCNN).
//!
//! u = m + Σ φₚ zₚ with the mean and features of a constrained prior, and for each zₚ a network of
//! one hidden layer of tanh units in place of a Gaussian process (4.28). All derivatives, in the
//! coordinates and in the weights, are in closed form.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::coefficients::PointCoefficients;
use crate::data::{Data, check};
use crate::error::GpError;
use crate::operator::{MOST_DERIVATIVES, Operator};
use crate::optimise::minimise;
use crate::posterior::standard_normal;
use crate::prior::Prior;
use crate::state::combine;

/// How a network is trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NetworkOptions {
    /// Hidden units of each latent function.
    pub width: usize,
    /// Random starts.
    pub restarts: usize,
    /// Iterations of each at most.
    pub iterations: usize,
    /// Seed of the starts.
    pub seed: u64,
}

impl Default for NetworkOptions {
    fn default() -> Self {
        Self { width: 16, restarts: 4, iterations: 2000, seed: 0 }
    }
}

/// A trained network.
#[derive(Debug)]
pub struct Network<const D: usize> {
    prior: Prior<D>,
    layout: Layout<D>,
    weights: Vec<f64>,
    /// Mean squared misfit, each group of observations counted as in (4.49); infinite before training.
    pub loss: f64,
}

/// Where a part's weights are: for each unit an output weight, a bias and D input weights; last a constant.
#[derive(Clone, Debug)]
struct Layout<const D: usize> {
    width: usize,
    /// Axes of each part; a part without axes is its constant alone.
    axes: Vec<Vec<usize>>,
    /// Coordinates are mapped to [−1, 1].
    middle: [f64; D],
    half: [f64; D],
}

/// One group of observations: an operator compiled at its points.
struct Target<const D: usize> {
    points: PointCoefficients<D>,
    /// For each part, a_β.
    coefficients: Vec<Vec<f64>>,
    /// y − mean.
    residual: Vec<f64>,
}

/// Highest derivative of tanh: that of an operator along all axes, and one for the gradient.
const MOST_TANH: usize = MOST_DERIVATIVES * 3 + 2;

/// tanh and its derivatives, as polynomials in t = tanh: p′ₙ(t) (1 − t²).
fn tanh_derivatives(a: f64, count: usize) -> [f64; MOST_TANH] {
    let t = a.tanh();
    let mut polynomial = [0.0; MOST_TANH + 2];
    polynomial[1] = 1.0;
    let mut values = [0.0; MOST_TANH];
    for value in values.iter_mut().take(count) {
        *value = polynomial.iter().rev().fold(0.0, |sum, c| sum * t + c);
        let mut next = [0.0; MOST_TANH + 2];
        for k in 1..=MOST_TANH {
            let slope = k as f64 * polynomial[k];
            next[k - 1] += slope;
            if k < MOST_TANH + 1 {
                next[k + 1] -= slope;
            }
        }
        polynomial = next;
    }
    values
}

impl<const D: usize> Layout<D> {
    fn new(prior: &Prior<D>, width: usize) -> Self {
        let domain = &prior.domain;
        Self {
            width,
            axes: prior.parts.iter().map(|part| part.axes.clone()).collect(),
            middle: std::array::from_fn(|d| 0.5 * (domain.lower()[d] + domain.upper()[d])),
            half: domain.extents().map(|extent| 0.5 * extent),
        }
    }

    fn size_of(&self, part: usize) -> usize {
        if self.axes[part].is_empty() { 1 } else { self.width * (2 + D) + 1 }
    }

    fn size(&self) -> usize {
        (0..self.axes.len()).map(|part| self.size_of(part)).sum()
    }

    /// Adds `factor · ∂^β z` at `x` to the value, and the same of its gradient in the weights.
    fn add(
        &self,
        part: usize,
        weights: &[f64],
        x: [f64; D],
        (orders, factor): ([usize; D], f64),
        mut gradient: Option<&mut [f64]>,
    ) -> f64 {
        let order: usize = orders.iter().sum();
        let (units, constant) = weights.split_at(weights.len() - 1);
        let mut sum = if order == 0 { constant[0] } else { 0.0 };
        if let Some(gradient) = gradient.as_deref_mut().filter(|_| order == 0) {
            gradient[weights.len() - 1] += factor;
        }
        if self.axes[part].is_empty() {
            return factor * sum;
        }
        let scaled: [f64; D] = std::array::from_fn(|d| (x[d] - self.middle[d]) / self.half[d]);
        for (number, unit) in units.chunks(2 + D).enumerate() {
            let (output, bias, inputs) = (unit[0], unit[1], &unit[2..]);
            let axes = || self.axes[part].iter().copied();
            let a = bias + axes().map(|d| inputs[d] * scaled[d]).sum::<f64>();
            let tanh = tanh_derivatives(a, order + 2);
            let slope = |d: usize| inputs[d] / self.half[d];
            let power: f64 = axes().map(|d| slope(d).powi(orders[d] as i32)).product();
            sum += output * power * tanh[order];
            let Some(gradient) = gradient.as_deref_mut() else { continue };
            let own = &mut gradient[number * (2 + D)..][..2 + D];
            own[0] += factor * power * tanh[order];
            own[1] += factor * output * power * tanh[order + 1];
            for d in axes() {
                let mut by_input = power * tanh[order + 1] * scaled[d];
                if orders[d] > 0 {
                    let others: f64 = axes()
                        .map(|e| slope(e).powi(orders[e] as i32 - i32::from(e == d)))
                        .product();
                    by_input += orders[d] as f64 * others / self.half[d] * tanh[order];
                }
                own[2 + d] += factor * output * by_input;
            }
        }
        factor * sum
    }

    /// L u − L m at one point, and its gradient in the weights added with the factor `scale`.
    fn evaluate(
        &self,
        target: &Target<D>,
        point: usize,
        weights: &[f64],
        mut gradient: Option<(&mut [f64], f64)>,
    ) -> f64 {
        let x = std::array::from_fn(|d| target.points.axes[d][point]);
        let mut offset = 0;
        let mut sum = 0.0;
        for (part, compiled) in target.points.parts.iter().enumerate() {
            let range = offset..offset + self.size_of(part);
            for (number, orders) in compiled.orders.iter().enumerate() {
                let a = target.coefficients[part][number * target.points.count + point];
                let own = &weights[range.clone()];
                sum += match &mut gradient {
                    None => self.add(part, own, x, (*orders, a), None),
                    Some((gradient, scale)) => {
                        let slot = &mut gradient[range.clone()];
                        self.add(part, own, x, (*orders, a * *scale), Some(slot)) / *scale
                    }
                };
            }
            offset = range.end;
        }
        sum
    }

    /// Weights from the prior (4.30) with unit variances, the output weights' shared among the units.
    fn random(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let mut weights = Vec::with_capacity(self.size());
        for axes in &self.axes {
            if !axes.is_empty() {
                for _ in 0..self.width {
                    weights.push(standard_normal(random) / (self.width as f64).sqrt());
                    weights.extend((0..=D).map(|_| standard_normal(random)));
                }
            }
            weights.push(standard_normal(random));
        }
        weights
    }
}

impl<const D: usize> Network<D> {
    /// Trains on data by least squares (4.47–4.49), with L-BFGS from random starts.
    ///
    /// The operators' parameters must be known: an equation with free ones is refused. Noise
    /// levels are not used. Pseudo-observations of a penalised prior count as observations.
    ///
    /// # Errors
    /// If the data are unusable (see [`crate::Model::new`]), the equation has free parameters, or
    /// no start leads anywhere.
    pub fn train(
        prior: Prior<D>,
        data: &Data<D>,
        options: &NetworkOptions,
    ) -> Result<Self, GpError> {
        let mut groups = data.groups.clone();
        groups.extend(prior.boundary.iter().cloned());
        check(&groups)?;
        if groups.iter().any(|group| group.opposite.is_some()) {
            return Err(GpError::Network("jumps between the ends of a periodic axis"));
        }
        require_no_traces(&prior)?;
        let layout = Layout::new(&prior, options.width);
        let mut targets = Vec::new();
        for (number, group) in groups.iter().enumerate() {
            let operator = group.operator.as_ref().unwrap_or(&prior.equation);
            targets.push(target(&prior, operator, &group.points, &group.values, number)?);
        }
        let objective = |weights: &[f64]| {
            let mut loss = 0.0;
            let mut gradient = vec![0.0; weights.len()];
            for target in &targets {
                let count = target.residual.len().max(1) as f64;
                for (point, y) in target.residual.iter().enumerate() {
                    let misfit = layout.evaluate(target, point, weights, None) - y;
                    loss += misfit * misfit / count;
                    let scale = 2.0 * misfit / count;
                    if scale != 0.0 {
                        layout.evaluate(target, point, weights, Some((&mut gradient, scale)));
                    }
                }
            }
            Some((loss, gradient))
        };
        let mut random = ChaCha8Rng::seed_from_u64(options.seed);
        let bounds = vec![[-1e3, 1e3]; layout.size()];
        let best = (0..options.restarts.max(1))
            .filter_map(|_| {
                let start = layout.random(&mut random);
                minimise(objective, &start, &bounds, options.iterations, |_, _| ())
            })
            .min_by(|a, b| a.value.total_cmp(&b.value));
        let restarts = options.restarts;
        let best = best.ok_or(GpError::NoFit { restarts, last: Box::new(GpError::NoData) })?;
        Ok(Self { layout, weights: best.point, loss: best.value, prior })
    }

    /// A network that was not trained: weights drawn from normal distributions of variance one,
    /// 1/`width` for the output weights, in coordinates that run from −1 to 1 over the domain (4.30).
    ///
    /// As the width grows, u tends to the Gaussian process with the prior's mean and features and
    /// the kernel 1 + E tanh(b + w·x) tanh(b + w·x′) (Theorem 4.6.2).
    ///
    /// # Errors
    /// If the prior has parts that no network stands for: traces along the edges of a polygon.
    pub fn random(prior: Prior<D>, width: usize, seed: u64) -> Result<Self, GpError> {
        require_no_traces(&prior)?;
        let layout = Layout::new(&prior, width);
        let weights = layout.random(&mut ChaCha8Rng::seed_from_u64(seed));
        Ok(Self { layout, weights, loss: f64::INFINITY, prior })
    }

    /// u at points.
    ///
    /// # Errors
    /// If a feature has no finite value at a point.
    pub fn mean(&self, points: &[[f64; D]]) -> Result<Vec<f64>, GpError> {
        self.mean_of(&Operator::identity(), points)
    }

    /// An operator without parameters applied to u.
    ///
    /// # Errors
    /// As [`Network::mean`], and if the operator has parameters.
    pub fn mean_of(
        &self,
        operator: &Operator<D>,
        points: &[[f64; D]],
    ) -> Result<Vec<f64>, GpError> {
        let zeros = vec![0.0; points.len()];
        let target = target(&self.prior, operator, points, &zeros, 0)?;
        let values = (0..points.len()).map(|point| {
            // The residual of zeros is minus the mean.
            self.layout.evaluate(&target, point, &self.weights, None) - target.residual[point]
        });
        Ok(values.collect())
    }
}

fn require_no_traces<const D: usize>(prior: &Prior<D>) -> Result<(), GpError> {
    match prior.parts.iter().any(|part| part.direction.is_some()) {
        true => Err(GpError::Network("traces along the edges of a polygon")),
        false => Ok(()),
    }
}

fn target<const D: usize>(
    prior: &Prior<D>,
    operator: &Operator<D>,
    points: &[[f64; D]],
    values: &[f64],
    group: usize,
) -> Result<Target<D>, GpError> {
    let mut parameters = Vec::new();
    let compiled = PointCoefficients::new(prior, operator, points, &mut parameters)?.map_err(
        |(what, index)| GpError::Singular { what, index, group, point: points[index].to_vec() },
    )?;
    if let Some(free) = parameters.first() {
        return Err(GpError::FreeParameter(free.name().into()));
    }
    let ones = vec![1.0; compiled.monomials.len()];
    let coefficients =
        compiled.parts.iter().map(|part| combine(1.0, &ones, &part.arrays)).collect();
    let mut residual = values.to_vec();
    for mean in &compiled.mean {
        residual.iter_mut().zip(mean).for_each(|(r, m)| *r -= m);
    }
    Ok(Target { points: compiled, coefficients, residual })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_tanh_follow_their_recursion() {
        let t = 0.4_f64.tanh();
        let s = 1.0 - t * t;
        let values = tanh_derivatives(0.4, 4);
        let exact = [t, s, -2.0 * t * s, s * (6.0 * t * t - 2.0)];
        for (value, exact) in values.iter().zip(exact) {
            assert!((value - exact).abs() < 1e-14);
        }
    }

    #[test]
    fn gradients_equal_differences() {
        let layout =
            Layout { width: 3, axes: vec![vec![0, 1]], middle: [0.3, 0.1], half: [2.0, 0.7] };
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let weights = layout.random(&mut random);
        for orders in [[0, 0], [2, 0], [1, 2], [0, 1]] {
            let value = |w: &[f64]| layout.add(0, w, [0.9, -0.2], (orders, 1.5), None);
            let mut gradient = vec![0.0; weights.len()];
            layout.add(0, &weights, [0.9, -0.2], (orders, 1.5), Some(&mut gradient));
            for (number, slope) in gradient.iter().enumerate() {
                const STEP: f64 = 1e-5;
                let at = |step: f64| {
                    let mut moved = weights.clone();
                    moved[number] += step;
                    value(&moved)
                };
                let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
                assert!((slope - difference).abs() < 1e-8, "{orders:?} {number}");
            }
        }
    }

    #[test]
    fn wide_hidden_layers_have_the_covariance_of_the_limit() {
        // Given the hidden layer, u is Gaussian with the covariance mean of hⱼ(x) hⱼ(x′), which
        // tends to E h(x) h(x′) as 1/√width (Theorem 4.6.1).
        const LAYERS: usize = 60;
        let [x, y] = [[0.9], [-0.4]];
        let covariance = |width: usize, random: &mut ChaCha8Rng| {
            let layout = Layout { width, axes: vec![vec![0]], middle: [0.0], half: [1.0] };
            let weights = layout.random(random);
            let hidden = |at: [f64; 1]| {
                let mut gradient = vec![0.0; weights.len()];
                layout.add(0, &weights, at, ([0], 1.0), Some(&mut gradient));
                gradient.into_iter().step_by(3).take(width).collect::<Vec<f64>>()
            };
            let products = hidden(x).into_iter().zip(hidden(y)).map(|(a, b)| a * b);
            products.sum::<f64>() / width as f64
        };
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let limit = covariance(1_000_000, &mut random);
        let mut error = |width: usize| {
            let square = |_| (covariance(width, &mut random) - limit).powi(2);
            ((0..LAYERS).map(square).sum::<f64>() / LAYERS as f64).sqrt()
        };
        let errors = [16, 256, 4096].map(&mut error);
        println!("covariance of hidden layers: {errors:.4?} from the limit {limit:.4}");
        for pair in errors.windows(2) {
            // Four for sixteen times the width; sixty layers leave a tenth of scatter in each.
            assert!((2.8..5.6).contains(&(pair[0] / pair[1])), "{errors:?}");
        }
    }
}
