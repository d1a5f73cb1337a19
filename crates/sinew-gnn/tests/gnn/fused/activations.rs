//! Activations of all numbers of a tensor.

use super::comparison::{Comparison, device, random};
use burn::tensor::{Device, Tensor};
use sinew_gnn::fused::{Activation, activate, reference};

/// Rounding of the polynomial and of `2ⁿ − 1`, a few units in the last place.
const TOLERANCE: f64 = 4e-7;

fn exact(activation: Activation, x: f64) -> (f64, f64) {
    match activation {
        Activation::Celu if x > 0.0 => (x, 1.0),
        Activation::Celu => (x.exp_m1(), x.exp()),
        Activation::Tanh => (x.tanh(), 1.0 - x.tanh().powi(2)),
    }
}

fn values(activation: Activation, x: &[f32]) -> Vec<f32> {
    let x = Tensor::<1>::from_floats(x, &Device::flex());
    activate(x, activation).into_data().try_to_vec().unwrap()
}

#[test]
fn values_and_slopes_match_double_precision() {
    let x: Vec<f32> = (-4000..4000).map(|i| i as f32 * 2.3e-3).collect();
    for activation in [Activation::Celu, Activation::Tanh] {
        let leaf = Tensor::<1>::from_floats(&x[..], &device()).require_grad();
        let y = activate(leaf.clone(), activation);
        let d = leaf.grad(&y.clone().sum().backward()).unwrap();
        let d = d.into_data().try_to_vec::<f32>().unwrap();
        let y = y.into_data().try_to_vec::<f32>().unwrap();
        for i in 0..x.len() {
            let (value, slope) = exact(activation, f64::from(x[i]));
            assert!(
                (f64::from(y[i]) - value).abs() <= TOLERANCE * value.abs(),
                "{activation:?}({})",
                x[i]
            );
            assert!((f64::from(d[i]) - slope).abs() <= TOLERANCE, "{activation:?}'({})", x[i]);
        }
    }
}

/// Arguments below zero, where activations are eˣ − 1 and its quotients, densely near zero.
#[test]
fn digits_are_kept_over_the_whole_range() {
    let mut x = vec![-87.0_f32];
    while let Some(&last) = x.last().filter(|last| **last < 30.0) {
        x.push(last + if last.abs() < 1.0 { 1.7e-5 } else { 1.3e-3 });
    }
    x.extend([1e-30, -1e-30]);
    for (activation, tolerance) in [(Activation::Celu, 3e-7), (Activation::Tanh, TOLERANCE)] {
        for (x, y) in x.iter().zip(values(activation, &x)) {
            let (value, _) = exact(activation, f64::from(*x));
            let error = (f64::from(y) - value).abs();
            assert!(error <= tolerance * value.abs(), "{activation:?}({x}): {y} vs {value}");
        }
    }
}

#[test]
fn limits_and_not_a_number() {
    let x = [f32::NEG_INFINITY, -1e30, -0.0, 0.0, 1e30, f32::INFINITY, f32::NAN];
    let y = values(Activation::Celu, &x);
    assert_eq!(y[..6], [-1.0, -1.0, 0.0, 0.0, 1e30, f32::INFINITY]);
    assert!(y[6].is_nan());
    let y = values(Activation::Tanh, &x);
    assert_eq!(y[..6], [-1.0, -1.0, 0.0, 0.0, 1.0, 1.0]);
    assert!(y[6].is_nan());
}

#[test]
fn agrees_with_plain_tensors() {
    let device = device();
    for activation in [Activation::Celu, Activation::Tanh] {
        for shape in [[1, 1], [3, 257], [300, 128]] {
            Comparison::of([random(shape, 3, &device) * 3.0]).assert_close(
                |x| activate(x[0].clone(), activation),
                |x| reference::activate(x[0].clone(), activation),
            );
        }
    }
}

#[test]
fn large_inputs_have_finite_slopes() {
    let x = random([2, 3], 4, &device()).mul_scalar(0.0).add_scalar(200.0).require_grad();
    let gradients = activate(x.clone(), Activation::Celu).sum().backward();
    let slope = x.grad(&gradients).unwrap().into_data().try_to_vec::<f32>().unwrap();
    assert_eq!(slope, [1.0; 6]);
}
