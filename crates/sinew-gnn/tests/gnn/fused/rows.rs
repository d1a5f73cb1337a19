//! Sums of two tensors, concatenated and normalised rows, and distances of rows.

use super::comparison::{Comparison, device, random};
use burn::tensor::Tensor;
use sinew_gnn::fused::{
    Activation, LayerNormalisation, activate, concatenated, mean_distance, normalised, reference,
    sum,
};

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
        };
        let row = |seed| random([1, width], seed, &device);
        Comparison::of([x(), row(5), row(6)]).assert_close(
            |x| normalised(x[0].clone(), rule(x)),
            |x| reference::normalised(x[0].clone(), rule(x)),
        );
    }
}

#[test]
fn parts_are_concatenated_like_plain_tensors() {
    let device = device();
    let parts =
        || [random([6, 2], 1, &device), random([6, 3], 2, &device), random([6, 1], 3, &device)];
    Comparison::of(parts())
        .assert_close(|x| concatenated(x.to_vec(), 1), |x| Tensor::cat(x.to_vec(), 1));
    // Two samples with nodes of their own, and more parts than an operation takes.
    for count in [2, 5] {
        let part = |nodes: usize| random([2 * 3, nodes], nodes as u64, &device);
        let cases: Vec<_> = (1..=count).map(part).collect();
        let blocks = |x: &[Tensor<2>]| -> Vec<Tensor<3>> {
            x.iter().map(|x| x.clone().reshape([2, x.dims()[1], 3])).collect()
        };
        let flat = |x: Tensor<3>| x.flatten::<2>(1, 2);
        Comparison::of(cases).assert_close(
            |x| flat(concatenated(blocks(x), 1)),
            |x| flat(Tensor::cat(blocks(x), 1)),
        );
    }
}

#[test]
fn distances_of_rows_agree_with_plain_tensors() {
    let device = device();
    let y: Vec<f32> = (0..24).map(|i| (i as f32 * 0.7).sin()).collect();
    let given = Tensor::<1>::from_floats(&y[..], &device).reshape([2, 4, 3]);
    let rows = |x: &[Tensor<2>]| x[0].clone().reshape([2, 4, 3]);
    Comparison::of([random([8, 3], 9, &device)]).assert_close(
        |x| mean_distance(rows(x), y.clone(), 2.5, 1e-3).unsqueeze(),
        |x| {
            reference::mean_norm((rows(x) - given.clone().cast(x[0].dtype())) / 2.5, 1e-3)
                .unsqueeze()
        },
    );
}
