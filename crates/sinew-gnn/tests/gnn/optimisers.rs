//! Steps of the optimisers beside their rules, written down in double precision.

use crate::common::*;
use crate::fused::by_plain_sums;
use sinew_gnn::*;

/// Added to the root of Adam's second moment.
const EPSILON: f64 = 1e-8;

/// Moments of the gradients of one parameter.
#[derive(Clone, Default)]
struct Memory {
    first: Vec<f64>,
    second: Vec<f64>,
}

impl Memory {
    fn update(&mut self, gradient: &[f64], beta1: f64, beta2: f64) {
        self.first.resize(gradient.len(), 0.0);
        self.second.resize(gradient.len(), 0.0);
        for ((m, v), g) in self.first.iter_mut().zip(&mut self.second).zip(gradient) {
            *m = beta1 * *m + (1.0 - beta1) * g;
            *v = beta2 * *v + (1.0 - beta2) * g * g;
        }
    }

    /// Sum of first moment and gradient, each times its factor.
    fn ahead(&self, gradient: &[f64], [of_first, of_gradient]: [f64; 2]) -> Vec<f64> {
        let pairs = self.first.iter().zip(gradient);
        pairs.map(|(m, g)| of_first * m + of_gradient * g).collect()
    }

    /// Adam's direction after `step` steps.
    fn adam(&self, gradient: &[f64], factors: [f64; 2], beta2: f64, step: i32) -> Vec<f64> {
        let root = |v: &f64| (v / (1.0 - beta2.powi(step))).sqrt() + EPSILON;
        let ahead = self.ahead(gradient, factors);
        ahead.iter().zip(&self.second).map(|(m, v)| m / root(v)).collect()
    }
}

/// Direction of change of a parameter of some shape after so many steps.
type Rule = fn(i32, &[usize], &mut Memory, &[f64]) -> Vec<f64>;

/// Kingma and Ba, 2015.
fn adam(step: i32, _: &[usize], memory: &mut Memory, gradient: &[f64]) -> Vec<f64> {
    memory.update(gradient, 0.9, 0.999);
    memory.adam(gradient, [1.0 / (1.0 - 0.9f64.powi(step)), 0.0], 0.999, step)
}

/// Nesterov momentum, orthogonalised where the parameter is a matrix, over the root of the second moment elsewhere.
fn muon(step: i32, shape: &[usize], memory: &mut Memory, gradient: &[f64]) -> Vec<f64> {
    let nesterov = |decay: f64| {
        let ahead = decay / (1.0 - decay.powi(step + 1));
        [ahead, (1.0 - decay) / (1.0 - decay.powi(step))]
    };
    if let &[inputs, outputs] = shape {
        memory.update(gradient, 0.95, 0.0);
        let orthogonal = by_plain_sums(memory.ahead(gradient, nesterov(0.95)), outputs);
        let scale = (outputs as f64 / inputs as f64).max(1.0).sqrt();
        return orthogonal.iter().map(|x| scale * x).collect();
    }
    memory.update(gradient, 0.9, 0.99);
    memory.adam(gradient, nesterov(0.9), 0.99, step)
}

/// Three directions of `optax.contrib.muon(1, adam_b2=0.99)`, optax 0.2.8.
#[test]
fn the_rule_of_muon_is_that_of_optax() {
    const MATRIX: [[f64; 6]; 3] = [
        [1.092_780_4, 0.050_371_867, 0.541_692_3, 0.737_810_55, 0.614_565_3, -0.588_036_8],
        [0.972_244_6, 0.161_869_48, 0.598_933_64, 0.696_222_84, 0.696_166_04, -0.466_080_1],
        [0.650_668_8, -0.024_569_36, 0.786_948_86, 0.398_546_3, 0.729_152_1, -0.595_892_25],
    ];
    const VECTOR: [[f64; 3]; 3] = [
        [1.473_683_1, -1.473_681_6, 1.473_683_1],
        [0.654_090_64, -0.654_089_75, 0.654_090_64],
        [-0.175_093_68, 0.175_093_49, -0.175_093_74],
    ];
    let (mut of_matrix, mut of_vector) = (Memory::default(), Memory::default());
    for (k, (matrix, vector)) in MATRIX.iter().zip(&VECTOR).enumerate() {
        let (step, k) = (k as i32 + 1, k as f64);
        let gradient = [0.3, -0.2, 0.5, 0.1, 0.4, -0.6].map(|g| (1.0 + k) * g + 0.1 * k * k);
        let found = muon(step, &[2, 3], &mut of_matrix, &gradient);
        let gradient = [0.2, -0.01, 0.5].map(|g| (1.0 - 0.8 * k) * g);
        let found = [found, muon(step, &[3], &mut of_vector, &gradient)].concat();
        for (found, expected) in found.iter().zip(matrix.iter().chain(vector)) {
            // Five iterations amplify rounding of single precision some tenfold.
            assert!((expected - found).abs() < 1e-5, "step {step}: {found} for {expected}");
        }
    }
}

/// Weights less those after a step of a training.
fn lost(before: &Surrogate, after: &Surrogate) -> Vec<(Vec<usize>, Vec<f64>)> {
    let pairs = weights(before.emulator()).into_iter().zip(weights(after.emulator()));
    pairs
        .map(|((shape, a), (_, b))| (shape, a.iter().zip(b).map(|(a, b)| a - b).collect()))
        .collect()
}

/// Compares three steps with a rule for the gradients at the same weights. These are found by a step that is so large that the
/// weights themselves are lost in rounding.
fn assert_steps(optimiser: OptimiserConfig, rule: Rule, tolerance: f64) {
    const LARGE: f64 = (1u64 << 20) as f64;
    const RATE: f64 = 1.0 / 16.0;
    let data = one_sample();
    let start = briefly_trained(&data, &small_config(&data, 2), &devices()[0]);
    let config = TrainingConfig {
        optimiser,
        schedule: Schedule::Constant,
        learning_rate: RATE,
        gradient_norm_limit: None,
        budget: TrainingBudget::Steps(8),
        batch: 1,
        ..TrainingConfig::default()
    };
    let objective = data_fit(&start);
    let mut trainer = Trainer::new(start, data.clone(), objective, config).unwrap();
    let mut memories = Vec::new();
    for step in 1..=3 {
        let before = trainer.current_surrogate();
        let mut descending = descent(&before, &data, data_fit(&before), LARGE);
        descending.step().unwrap();
        let gradients = lost(&before, &descending.current_surrogate());
        trainer.step().unwrap();
        let moved = lost(&before, &trainer.current_surrogate());
        memories.resize(gradients.len(), Memory::default());
        for (((shape, gradient), memory), (_, moved)) in
            gradients.iter().zip(&mut memories).zip(&moved)
        {
            let gradient: Vec<f64> = gradient.iter().map(|g| g / LARGE).collect();
            let expected = rule(step, shape, memory, &gradient);
            for (moved, expected) in moved.iter().zip(&expected) {
                let found = moved / RATE;
                let close = (found - expected).abs() < tolerance;
                assert!(close, "step {step} of {shape:?}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn steps_of_adam_are_those_of_its_rule() {
    // One less the decays has five digits in single precision.
    assert_steps(OptimiserConfig::adam(), adam, 1e-4);
}

#[test]
fn steps_of_muon_are_those_of_its_rule() {
    // Small singular values of a gradient are amplified, and its rounding with them.
    assert_steps(OptimiserConfig::default(), muon, 2e-4);
}
