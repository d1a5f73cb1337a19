//! Tensors as numbers of a formula.

use super::comparison::device;
use crate::lanes::Lanes;
use burn::tensor::{DType, Tensor, TensorData};
use sinew_num::{Jet, Scalar};

/// Uses every operation of a number.
fn formula<S: Scalar>(x: S) -> S {
    let smooth = x.clone().exp() * 0.1 + x.clone().exp_m1() / (x.clone().squared() + 2.0);
    let logarithms = x.clone().at_least(0.25).ln() - x.clone().at_least(-0.5).ln_1p();
    let selected = x.select_below(0.3, -x.clone(), x.clone().tanh());
    smooth + logarithms * 0.5 + selected - x.constant(0.125) + x.at_most(1.0) - 0.5
}

#[test]
fn lanes_agree_with_jets_in_double_precision() {
    let x: Vec<f64> = (0..60).map(|i| -3.0 + 0.1013 * f64::from(i)).collect();
    let device = device();
    let lanes = Tensor::<1>::from_data(TensorData::new(x.clone(), [60]), (&device, DType::F64))
        .require_grad();
    let y = formula(Lanes(lanes.clone())).0;
    let values = y.to_data().try_to_vec::<f64>().unwrap();
    let slopes = lanes.grad(&y.sum().backward()).unwrap().into_data().try_to_vec::<f64>().unwrap();
    for i in 0..x.len() {
        let jet = formula(Jet::<1>::variable(x[i], 0));
        // Rounding in double precision.
        assert!((values[i] - jet.value).abs() < 1e-13, "value at {}", x[i]);
        assert!((slopes[i] - jet.gradient[0]).abs() < 1e-12, "slope at {}", x[i]);
    }
}

#[test]
fn single_precision_keeps_its_digits_near_zero() {
    let x = [1e-6_f32, -3e-5, 2e-3, 0.9, -0.9, 1.1, -20.0];
    let lanes = Lanes(Tensor::<1>::from_floats(x, &device()));
    let y = lanes.exp_m1().0.into_data().try_to_vec::<f32>().unwrap();
    for (x, y) in x.iter().zip(y) {
        let exact = f64::from(*x).exp_m1();
        assert!((f64::from(y) - exact).abs() <= 4e-7 * exact.abs(), "at {x}: {y} vs {exact}");
    }
}

#[test]
fn logarithms_are_minus_infinity_outside_their_domain() {
    let lanes = |x: f32| Lanes(Tensor::<1>::from_floats([x], &device()));
    for x in [0.0, -1.0, -7.0] {
        assert_eq!(lanes(x).ln().0.into_scalar::<f32>(), f32::NEG_INFINITY);
        assert_eq!(lanes(x - 1.0).ln_1p().0.into_scalar::<f32>(), f32::NEG_INFINITY);
    }
}

#[test]
fn parameters_per_sample_meet_strains_per_element() {
    let device = device();
    let stiffness = Lanes(Tensor::<2>::from_floats([[1.0], [2.0]], &device));
    let strain = Lanes(Tensor::<2>::from_floats([[0.5, 3.0, 4.0]], &device));
    let energy = strain.clone().select_below(1.0, stiffness.clone(), stiffness * strain);
    assert_eq!(energy.0.into_data().try_to_vec::<f32>().unwrap(), [1.0, 3.0, 4.0, 2.0, 6.0, 8.0]);
}
