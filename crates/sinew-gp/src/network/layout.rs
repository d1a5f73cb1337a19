//! Weights of the latent functions, and these functions' derivatives in coordinates and weights.

use crate::constraint::Feature;
use crate::operator::MOST_DERIVATIVES;
use crate::posterior::standard_normal;
use crate::prior::Prior;
use crate::series::MOST_VARIABLES;
use rand_chacha::ChaCha8Rng;

/// s = shift + slope · x along one axis: what a unit sees of a point.
#[derive(Clone, Debug)]
pub(super) struct Input {
    axis: usize,
    slope: f64,
    shift: f64,
}

impl Input {
    /// A coordinate, mapped so that the ends go to −1 and 1.
    fn between([lower, upper]: [f64; 2], axis: usize) -> Self {
        let half = 0.5 * (upper - lower);
        Self { axis, slope: half.recip(), shift: -0.5 * (lower + upper) / half }
    }

    fn at<const D: usize>(&self, x: [f64; D]) -> f64 {
        self.shift + self.slope * x[self.axis]
    }
}

/// Offsets of a part's weights: for each unit an output weight, a bias and one weight for each
/// input; last a constant. A part without inputs is its constant alone.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub width: usize,
    /// Inputs of each part.
    pub parts: Vec<Vec<Input>>,
}

/// A derivative of a latent function, and what it is multiplied by.
pub(super) type Term<const D: usize> = ([usize; D], f64);

/// Derivatives of tanh at hand: those of an operator along all axes, and one for the gradient.
const MOST_TANH: usize = MOST_DERIVATIVES * MOST_VARIABLES + 2;

/// tanh and its first derivatives, as many as there is room for.
fn tanh_derivatives(a: f64, values: &mut [f64]) {
    // t' = 1 − t² read as a recursion for the Taylor coefficients.
    values[0] = a.tanh();
    for k in 1..values.len() {
        let square: f64 = (0..k).map(|i| values[i] * values[k - 1 - i]).sum();
        values[k] = (f64::from(u8::from(k == 1)) - square) / k as f64;
    }
    let mut factorial = 1.0;
    for (k, value) in values.iter_mut().enumerate().skip(1) {
        factorial *= k as f64;
        *value *= factorial;
    }
}

/// Inputs of a part of the prior.
fn inputs<const D: usize>(prior: &Prior<D>, part: &Feature<D>) -> Vec<Input> {
    let domain = &prior.domain;
    let ends = |axis: usize| match (axis, part.direction, domain.cross_section()) {
        // Positions of the corners along the direction.
        (0, Some([nx, ny]), Some(polygon)) => {
            let along = polygon.corners().iter().map(|[x, y]| nx * x + ny * y);
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[lower, upper], s| {
                [lower.min(s), upper.max(s)]
            })
        }
        _ => [domain.lower()[axis], domain.upper()[axis]],
    };
    let across = |axis: usize| axis == 1 && part.direction.is_some();
    let axes = part.axes.iter().copied().filter(|axis| !across(*axis));
    axes.map(|axis| Input::between(ends(axis), axis)).collect()
}

impl Layout {
    pub(super) fn new<const D: usize>(prior: &Prior<D>, width: usize) -> Self {
        let parts = prior.parts.iter().map(|part| inputs(prior, &part.feature)).collect();
        Self { width, parts }
    }

    pub(super) fn size_of(&self, part: usize) -> usize {
        match self.parts[part].len() {
            0 => 1,
            inputs => self.width * (2 + inputs) + 1,
        }
    }

    pub(super) fn size(&self) -> usize {
        (0..self.parts.len()).map(|part| self.size_of(part)).sum()
    }

    /// Σ factor · ∂^β z at `x` over `terms`, its gradient in the weights added to `gradient`.
    pub(super) fn add<const D: usize>(
        &self,
        part: usize,
        weights: &[f64],
        x: [f64; D],
        terms: &[Term<D>],
        mut gradient: Option<&mut [f64]>,
    ) -> f64 {
        let total = |orders: &[usize; D]| orders.iter().sum::<usize>();
        let constant = weights.len() - 1;
        let share: f64 =
            terms.iter().filter(|(orders, _)| total(orders) == 0).map(|(_, factor)| factor).sum();
        if let Some(gradient) = gradient.as_deref_mut() {
            gradient[constant] += share;
        }
        let mut sum = share * weights[constant];
        let inputs = &self.parts[part];
        let stride = 2 + inputs.len();
        let seen: Vec<f64> = inputs.iter().map(|input| input.at(x)).collect();
        let most = terms.iter().map(|(orders, _)| total(orders)).max().unwrap_or(0);
        let mut tanh = [0.0; MOST_TANH];
        for (number, unit) in weights[..constant].chunks_exact(stride).enumerate() {
            let (output, bias, incoming) = (unit[0], unit[1], &unit[2..]);
            let a = bias + std::iter::zip(incoming, &seen).map(|(w, s)| w * s).sum::<f64>();
            tanh_derivatives(a, &mut tanh[..most + 2]);
            let mut slope = [0.0; D];
            for (w, input) in std::iter::zip(incoming, inputs) {
                slope[input.axis] = w * input.slope;
            }
            for (orders, factor) in terms {
                let order = total(orders);
                let power: f64 = (0..D).map(|d| slope[d].powi(orders[d] as i32)).product();
                sum += factor * output * power * tanh[order];
                let Some(gradient) = gradient.as_deref_mut() else { continue };
                let own = &mut gradient[number * stride..][..stride];
                own[0] += factor * power * tanh[order];
                own[1] += factor * output * power * tanh[order + 1];
                // The power's derivative in the slope along each axis.
                let lowered: [f64; D] = std::array::from_fn(|d| match orders[d] {
                    0 => 0.0,
                    n => {
                        let less = |e: usize| orders[e] as i32 - i32::from(e == d);
                        n as f64 * (0..D).map(|e| slope[e].powi(less(e))).product::<f64>()
                    }
                });
                for (own, (input, s)) in own[2..].iter_mut().zip(inputs.iter().zip(&seen)) {
                    let of_power = input.slope * lowered[input.axis];
                    let by_input = power * tanh[order + 1] * s + of_power * tanh[order];
                    *own += factor * output * by_input;
                }
            }
        }
        sum
    }

    /// Weights from the prior (4.30) with unit variances, the output weights' shared among the units.
    pub(super) fn random(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let mut weights = Vec::with_capacity(self.size());
        for inputs in &self.parts {
            if !inputs.is_empty() {
                for _ in 0..self.width {
                    weights.push(standard_normal(random) / (self.width as f64).sqrt());
                    weights.extend((0..=inputs.len()).map(|_| standard_normal(random)));
                }
            }
            weights.push(standard_normal(random));
        }
        weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn gradients_equal_differences() {
        let axes = vec![Input::between([-1.7, 2.3], 0), Input::between([-0.6, 0.8], 1)];
        let layout = Layout { width: 3, parts: vec![axes, vec![Input::between([-0.4, 1.9], 1)]] };
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let all = layout.random(&mut random);
        assert_eq!(all.len(), layout.size());
        let (first, second) = all.split_at(layout.size_of(0));
        let terms = [([0, 0], 1.5), ([2, 0], -0.3), ([1, 2], 0.2), ([0, 1], 0.7)];
        for (part, weights) in [first, second].into_iter().enumerate() {
            for terms in terms.chunks(1).chain([&terms[..]]) {
                let value = |w: &[f64]| layout.add(part, w, [0.9, -0.2], terms, None);
                let mut gradient = vec![0.0; weights.len()];
                layout.add(part, weights, [0.9, -0.2], terms, Some(&mut gradient));
                for (number, slope) in gradient.iter().enumerate() {
                    const STEP: f64 = 1e-5;
                    let at = |step: f64| {
                        let mut moved = weights.to_vec();
                        moved[number] += step;
                        value(&moved)
                    };
                    let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
                    assert!((slope - difference).abs() < 1e-8, "{part} {terms:?} {number}");
                }
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
            let layout = Layout { width, parts: vec![vec![Input::between([-1.0, 1.0], 0)]] };
            let weights = layout.random(random);
            let hidden = |at: [f64; 1]| {
                let mut gradient = vec![0.0; weights.len()];
                layout.add(0, &weights, at, &[([0], 1.0)], Some(&mut gradient));
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
