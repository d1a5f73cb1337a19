//! A network with two hidden layers and one input, with its first two derivatives in the input and all
//! derivatives in the weights in closed form: what the introduction's PINN needs (§1.7.3).

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Units of each hidden layer.
pub(crate) const WIDTH: usize = 16;
/// Offset of each group of weights: input weights and biases, matrix and biases, output weights and bias.
const FIRST_BIAS: usize = WIDTH;
const MATRIX: usize = 2 * WIDTH;
const SECOND_BIAS: usize = MATRIX + WIDTH * WIDTH;
const OUTPUT: usize = SECOND_BIAS + WIDTH;
pub(crate) const WEIGHTS: usize = OUTPUT + WIDTH + 1;
/// The input x in [0, 1] enters as 2x − 1.
const STRETCH: f64 = 2.0;

/// A function of x with its first two derivatives, or an adjoint of these.
pub(crate) type Jet = [f64; 3];

/// A layer's values at one point.
type Layer = [Jet; WIDTH];

/// Weights at which the variance of signals keeps its size (Glorot & Bengio 2010).
pub(crate) fn random_weights(seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut weights = vec![0.0; WEIGHTS];
    let mut fill = |range: std::ops::Range<usize>, inputs: usize, outputs: usize| {
        let limit = (6.0 / (inputs + outputs) as f64).sqrt();
        weights[range].iter_mut().for_each(|w| *w = random.random_range(-limit..limit));
    };
    fill(0..FIRST_BIAS, 1, WIDTH);
    // Units bend at places all over the interval.
    fill(FIRST_BIAS..MATRIX, 1, WIDTH);
    fill(MATRIX..SECOND_BIAS, WIDTH, WIDTH);
    fill(OUTPUT..WEIGHTS - 1, WIDTH, 1);
    weights
}

/// Activations that the backward pass needs.
pub(crate) struct Trace {
    input: f64,
    before: [Layer; 2],
    after: [Layer; 2],
    /// The network's value and derivatives.
    pub output: Jet,
}

/// tanh z with its derivatives in z up to the third.
pub(crate) fn tanh(z: f64) -> [f64; 4] {
    let t = z.tanh();
    let first = 1.0 - t * t;
    [t, first, -2.0 * t * first, first * (6.0 * t * t - 2.0)]
}

fn activate(z: &Layer) -> Layer {
    let mut after = *z;
    for [z, slope, bend] in &mut after {
        let [t, first, second, _] = tanh(*z);
        (*z, *bend) = (t, second * *slope * *slope + first * *bend);
        *slope *= first;
    }
    after
}

/// Adjoint of [`activate`].
fn activate_back(z: &Layer, adjoint: &Layer) -> Layer {
    let mut before = *adjoint;
    for unit in 0..WIDTH {
        let ([z, slope, bend], [a, b, c]) = (z[unit], adjoint[unit]);
        let [_, first, second, third] = tanh(z);
        before[unit] = [
            a * first + b * second * slope + c * (third * slope * slope + second * bend),
            b * first + 2.0 * c * second * slope,
            c * first,
        ];
    }
    before
}

/// Adds a multiple.
fn add([value, slope, bend]: &mut Jet, factor: f64, jet: &Jet) {
    *value += factor * jet[0];
    *slope += factor * jet[1];
    *bend += factor * jet[2];
}

/// The network at x.
pub(crate) fn forward(weights: &[f64], x: f64) -> Trace {
    let input = STRETCH * x - 1.0;
    let [mut first, mut second]: [Layer; 2] = [[[0.0; 3]; WIDTH]; 2];
    for unit in 0..WIDTH {
        first[unit] =
            [weights[unit] * input + weights[FIRST_BIAS + unit], weights[unit] * STRETCH, 0.0];
    }
    let hidden = activate(&first);
    for unit in 0..WIDTH {
        let row = &weights[MATRIX + WIDTH * unit..][..WIDTH];
        second[unit][0] = weights[SECOND_BIAS + unit];
        for k in 0..WIDTH {
            add(&mut second[unit], row[k], &hidden[k]);
        }
    }
    let last = activate(&second);
    let mut output = [weights[WEIGHTS - 1], 0.0, 0.0];
    for (w, jet) in weights[OUTPUT..].iter().zip(&last) {
        add(&mut output, *w, jet);
    }
    Trace { input, before: [first, second], after: [hidden, last], output }
}

/// Adds to `gradient` the derivatives in the weights of an objective with the given derivatives in the output.
pub(crate) fn backward(weights: &[f64], trace: &Trace, adjoint: Jet, gradient: &mut [f64]) {
    let dot = |a: &Jet, b: &Jet| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let [hidden, last] = &trace.after;
    for (g, jet) in gradient[OUTPUT..].iter_mut().zip(last) {
        *g += dot(&adjoint, jet);
    }
    gradient[WEIGHTS - 1] += adjoint[0];
    let to_last: Layer = std::array::from_fn(|unit| adjoint.map(|a| a * weights[OUTPUT + unit]));
    let second = activate_back(&trace.before[1], &to_last);
    let mut to_hidden: Layer = [[0.0; 3]; WIDTH];
    for (unit, own) in second.iter().enumerate() {
        gradient[SECOND_BIAS + unit] += own[0];
        let start = MATRIX + WIDTH * unit;
        for k in 0..WIDTH {
            gradient[start + k] += dot(own, &hidden[k]);
            add(&mut to_hidden[k], weights[start + k], own);
        }
    }
    let first = activate_back(&trace.before[0], &to_hidden);
    for (unit, own) in first.iter().enumerate() {
        gradient[unit] += own[0] * trace.input + own[1] * STRETCH;
        gradient[FIRST_BIAS + unit] += own[0];
    }
}

/// Adam (Kingma & Ba 2015) with the learning rate falling exponentially between two ends.
pub(crate) fn adam(
    weights: &mut [f64],
    steps: usize,
    [from, to]: [f64; 2],
    mut gradient_of: impl FnMut(&[f64]) -> Vec<f64>,
) {
    const DECAY: [f64; 2] = [0.9, 0.999];
    const SMALL: f64 = 1e-10;
    let mut moments = vec![[0.0; 2]; weights.len()];
    for step in 0..steps {
        let rate = from * (to / from).powf(step as f64 / steps as f64);
        let bias = DECAY.map(|decay| 1.0 - decay.powi(step as i32 + 1));
        let gradient = gradient_of(weights);
        for ((w, g), [mean, square]) in weights.iter_mut().zip(&gradient).zip(&mut moments) {
            *mean += (1.0 - DECAY[0]) * (g - *mean);
            *square += (1.0 - DECAY[1]) * (g * g - *square);
            *w -= rate * (*mean / bias[0]) / ((*square / bias[1]).sqrt() + SMALL);
        }
    }
}
