//! Comparison of an operation with its oracle: values, all gradients, and finite differences.

use crate::common::devices;
use burn::tensor::{DType, Device, Tensor, TensorData};

/// Single-precision sums in another order, relative to the largest number of a tensor.
const AGREEMENT: f64 = 1e-5;
/// Step of the finite differences: the optimum between truncation and rounding in f32.
const STEP: f64 = 4e-3;
/// Truncation: fourth derivatives times the step's fourth power, and kinks of an activation.
const TRUNCATION: f64 = 2e-3;
/// Rounding of each value, a few units in the last place, over the step.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64 / STEP;

/// The backend under test, differentiable: ndarray where that feature is on, else Flex.
pub(super) fn device() -> Device {
    devices().pop().expect("Flex is always there").autodiff()
}

/// Numbers in (−1, 1) from a seed.
pub(super) fn random<const D: usize>(shape: [usize; D], seed: u64, device: &Device) -> Tensor<D> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mut next = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z >> 40) as f32 + 0.5) / (1_u64 << 23) as f32 - 1.0
    };
    let values: Vec<f32> = (0..shape.iter().product()).map(|_| next()).collect();
    Tensor::from_data(TensorData::new(values, shape), device)
}

/// Inputs on which two functions are compared.
pub(super) struct Comparison(Vec<Tensor<2>>);

impl Comparison {
    pub(super) fn of(inputs: impl Into<Vec<Tensor<2>>>) -> Self {
        Self(inputs.into())
    }

    /// Values and gradients of `operation` agree with those of `oracle` evaluated in double
    /// precision, and its derivative along a random direction with finite differences.
    pub(super) fn assert_close(
        &self,
        operation: impl Fn(&[Tensor<2>]) -> Tensor<2>,
        oracle: impl Fn(&[Tensor<2>]) -> Tensor<2>,
    ) {
        let single = evaluate(&self.0, &operation, &weights);
        let double: Vec<_> = self.0.iter().map(|x| x.clone().cast(DType::F64)).collect();
        let exact = evaluate(&double, &oracle, &weights);
        for (number, (found, expected)) in single.iter().zip(&exact).enumerate() {
            assert_eq!(found.len(), expected.len());
            let scale =
                expected.iter().fold(0.0_f64, |most, x| most.max(x.abs())).max(f64::MIN_POSITIVE);
            let error =
                found.iter().zip(expected).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            assert!(
                error.is_finite() && error <= AGREEMENT * scale,
                "result {number}: error {error:e} of {scale:e}"
            );
        }
        self.assert_finite_differences(&operation, &single[1..]);
    }

    fn assert_finite_differences(
        &self,
        operation: &impl Fn(&[Tensor<2>]) -> Tensor<2>,
        gradients: &[Vec<f64>],
    ) {
        let directions: Vec<_> = self
            .0
            .iter()
            .enumerate()
            .map(|(i, x)| random(x.dims(), 100 + i as u64, &x.device()))
            .collect();
        let along: f64 = gradients
            .iter()
            .zip(&directions)
            .map(|(gradient, direction)| {
                gradient.iter().zip(numbers(direction)).map(|(g, d)| g * d).sum::<f64>()
            })
            .sum();
        let at = |step: f64| {
            let moved: Vec<_> =
                self.0.iter().zip(&directions).map(|(x, d)| x.clone() + d.clone() * step).collect();
            let output = operation(&moved);
            let weights = weights(&output);
            numbers(&output).iter().zip(numbers(&weights)).map(|(y, w)| y * w).sum::<f64>()
        };
        // Fourth order, so that the step can be large.
        let difference =
            (8.0 * (at(STEP) - at(-STEP)) - (at(2.0 * STEP) - at(-2.0 * STEP))) / (12.0 * STEP);
        let slopes = gradients
            .iter()
            .zip(&directions)
            .map(|(gradient, d)| norm_of_products(gradient, &numbers(d)));
        let scale = slopes.fold(along.abs(), f64::max);
        let output = operation(&self.0);
        let bound = TRUNCATION * scale
            + ROUNDING * norm_of_products(&numbers(&output), &numbers(&weights(&output)));
        assert!(
            (along - difference).abs() <= bound,
            "derivative {along:e}, finite difference {difference:e}, bound {bound:e}"
        );
    }
}

fn norm_of_products(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a * b).powi(2)).sum::<f64>().sqrt()
}

/// Random weights, so that the gradients of all outputs differ.
fn weights(output: &Tensor<2>) -> Tensor<2> {
    random(output.dims(), 99, &output.device()).cast(output.dtype())
}

pub(super) fn numbers(x: &Tensor<2>) -> Vec<f64> {
    x.clone().cast(DType::F64).into_data().try_to_vec::<f64>().unwrap()
}

/// The output, and the gradients of the sum of its numbers times `weights` of it.
pub(super) fn evaluate(
    inputs: &[Tensor<2>],
    function: &impl Fn(&[Tensor<2>]) -> Tensor<2>,
    weights: &impl Fn(&Tensor<2>) -> Tensor<2>,
) -> Vec<Vec<f64>> {
    let inputs: Vec<_> = inputs.iter().map(|x| x.clone().detach().require_grad()).collect();
    let output = function(&inputs);
    let gradients = (output.clone() * weights(&output)).sum().backward();
    let gradient =
        |x: &Tensor<2>| numbers(&x.grad(&gradients).expect("every input has a gradient"));
    std::iter::once(numbers(&output)).chain(inputs.iter().map(gradient)).collect()
}
