//! Sums of two tensors and normalised rows.

use super::comparison::{Comparison, device, random};
use burn::tensor::Tensor;
use sinew_gnn::fused::{Activation, LayerNormalisation, activate, normalised, reference, sum};

/// Host operations add to gradients that others have begun, before and after Burn's own operations do.
#[test]
fn gradients_of_a_shared_tensor_are_summed() {
    let by = |x: &Tensor<2>,
              sum: fn(Tensor<2>, Tensor<2>) -> Tensor<2>,
              activate: fn(Tensor<2>, Activation) -> Tensor<2>| {
        let shared = x.clone() * 1.5;
        let active = activate(shared.clone(), Activation::Tanh);
        let first = sum(shared.clone(), shared.clone()) * active.clone() + shared.clone() * 3.0;
        sum(first, sum(activate(shared.clone(), Activation::Celu), shared * active))
    };
    Comparison::of([random([5, 3], 7, &device())]).assert_close(
        |x| by(&x[0], sum, activate),
        |x| by(&x[0], |a, b| a + b, reference::activate),
    );
}

#[test]
fn agree_with_plain_tensors() {
    let device = device();
    for [rows, width] in [[1, 3], [5, 8], [300, 80]] {
        let x = || random([rows, width], 3, &device);
        Comparison::of([x(), random([rows, width], 4, &device)])
            .assert_close(|x| sum(x[0].clone(), x[1].clone()), |x| x[0].clone() + x[1].clone());
        let rule = |x: &[Tensor<2>]| LayerNormalisation {
            gain: x[1].clone().squeeze_dim(0),
            offset: x[2].clone().squeeze_dim(0),
            epsilon: 1e-6,
        };
        let row = |seed| random([1, width], seed, &device);
        Comparison::of([x(), row(5), row(6)]).assert_close(
            |x| normalised(x[0].clone(), rule(x)),
            |x| reference::normalised(x[0].clone(), rule(x)),
        );
    }
}
