//! Fused perceptrons against plain tensors.

use super::{Input, LayerNormalisation, PerceptronWeights, evaluate, gathered_mlp};
use crate::fused::tests::{Comparison, device, random};
use crate::fused::{Activation, EdgeTopology, GatherPlan, reference};
use burn::tensor::Tensor;
use std::sync::Arc;

/// Width of every input that is multiplied with the first weight.
const FEATURES: usize = 9;

/// Inputs first, then the parameters; vectors as matrices of one row. The last input is a
/// product already if there are several.
fn inputs(plan: &GatherPlan, [first, second, outputs]: [usize; 3]) -> Vec<Tensor<2>> {
    let device = device();
    let sources = plan.source_rows().len();
    let width = |k: usize| if k > 0 && k + 1 == sources { first } else { FEATURES };
    let mut inputs: Vec<_> = plan
        .source_rows()
        .iter()
        .enumerate()
        .map(|(k, &rows)| random([rows, width(k)], k as u64, &device))
        .collect();
    let scaled = |shape: [usize; 2], seed| random(shape, seed, &device) / (shape[0] as f64).sqrt();
    inputs.extend([
        // One row that no input meets.
        scaled([sources * FEATURES + 1, first], 10),
        random([1, first], 11, &device),
        scaled([first, second], 12),
        random([1, second], 13, &device),
        scaled([second, outputs], 14),
        random([1, outputs], 15, &device),
        random([1, outputs], 16, &device) + 1.0,
        random([1, outputs], 17, &device),
    ]);
    inputs
}

fn assemble(
    inputs: &[Tensor<2>],
    plan: &GatherPlan,
    activation: Activation,
    normalised: bool,
) -> (Vec<Input>, PerceptronWeights) {
    let (sources, p) = inputs.split_at(plan.source_rows().len());
    let vector = |i: usize| p[i].clone().flatten::<1>(0, 1);
    let normalisation = normalised.then(|| LayerNormalisation {
        gain: vector(6),
        offset: vector(7),
        epsilon: 1e-6,
    });
    let weights = PerceptronWeights {
        activation,
        first_weight: p[0].clone(),
        first_bias: vector(1),
        second_weight: p[2].clone(),
        second_bias: vector(3),
        third_weight: p[4].clone(),
        third_bias: vector(5),
        normalisation,
    };
    let input = |(k, values): (usize, &Tensor<2>)| match k > 0 && k + 1 == sources.len() {
        true => Input::Product(values.clone()),
        // In another order than that of the inputs.
        false => Input::Features {
            values: values.clone(),
            first_row: (sources.len() - 1 - k) * FEATURES,
        },
    };
    (sources.iter().enumerate().map(input).collect(), weights)
}

fn compare(plan: &Arc<GatherPlan>, widths: [usize; 3], activation: Activation, normalised: bool) {
    let mut all = inputs(plan, widths);
    if !normalised {
        all.truncate(all.len() - 2);
    }
    Comparison::of(all).assert_close(
        |x| {
            let (sources, weights) = assemble(x, plan, activation, normalised);
            gathered_mlp(sources, plan, weights)
        },
        |x| {
            let (sources, weights) = assemble(x, plan, activation, normalised);
            reference::gathered_mlp(sources, plan, weights)
        },
    );
}

fn topology(nodes: usize, edges: usize) -> Arc<EdgeTopology> {
    let senders: Vec<usize> = (0..edges).map(|i| (i * 7 + 3) % nodes).collect();
    let receivers: Vec<usize> = (0..edges).map(|i| (i * i + 5 * i) % nodes).collect();
    EdgeTopology::new(nodes, &senders, &receivers).unwrap()
}

#[test]
fn edges_agree_with_plain_tensors() {
    let plan = GatherPlan::edges(&topology(60, 300));
    compare(&plan, [32, 24, 10], Activation::Celu, true);
    compare(&plan, [33, 17, 5], Activation::Tanh, true);
    compare(&plan, [16, 16, 4], Activation::Celu, false);
}

#[test]
fn full_width_over_many_groups_agrees_with_plain_tensors() {
    compare(&GatherPlan::edges(&topology(200, 1500)), [128, 128, 40], Activation::Celu, true);
}

#[test]
fn identity_sources_agree_with_plain_tensors() {
    for sources in 1..=3 {
        let plan = GatherPlan::identity(131, sources);
        compare(&plan, [20, 12, 6], Activation::Celu, true);
        compare(&plan, [20, 12, 6], Activation::Celu, false);
    }
}

#[test]
fn single_outputs_over_an_outer_plan_agree_with_plain_tensors() {
    compare(&GatherPlan::outer(5, 61), [32, 32, 1], Activation::Celu, false);
    let shared = GatherPlan::outer(5, 61).and_shared();
    compare(&shared, [32, 32, 1], Activation::Celu, false);
    compare(&GatherPlan::outer(1, 7), [32, 32, 1], Activation::Tanh, false);
}

#[test]
fn recomputed_activations_give_the_same_gradients() {
    let nothing = |x: &[Tensor<2>], plan: &Arc<GatherPlan>, normalised| {
        let (sources, weights) = assemble(x, plan, Activation::Celu, normalised);
        evaluate(sources, plan, weights, 0)
    };
    for (plan, outputs, normalised) in
        [(GatherPlan::outer(6, 85), 1, false), (GatherPlan::edges(&topology(60, 300)), 12, true)]
    {
        let mut all = inputs(&plan, [32, 24, outputs]);
        all.truncate(all.len() - if normalised { 0 } else { 2 });
        Comparison::of(all).assert_close(
            |x| nothing(x, &plan, normalised),
            |x| {
                let (sources, weights) = assemble(x, &plan, Activation::Celu, normalised);
                reference::gathered_mlp(sources, &plan, weights)
            },
        );
    }
}

#[test]
fn no_rows_give_no_output_and_zero_gradients() {
    let plan = GatherPlan::identity(0, 1);
    let all: Vec<_> = inputs(&plan, [8, 8, 4]).into_iter().map(Tensor::require_grad).collect();
    let (sources, weights) = assemble(&all, &plan, Activation::Celu, true);
    let output = gathered_mlp(sources, &plan, weights);
    assert_eq!(output.dims(), [0, 4]);
    let gradients = output.sum().backward();
    let weight = all[3].grad(&gradients).unwrap().into_data().try_to_vec::<f32>().unwrap();
    assert_eq!(weight, [0.0; 64]);
}

#[test]
fn not_a_number_reaches_exactly_the_rows_that_read_it() {
    let plan = GatherPlan::indexed(&[0, 1, 1, 0], 2).unwrap();
    let mut all = inputs(&plan, [8, 8, 4]);
    all[0] = all[0].clone().slice_fill([1..2, 3..4], f32::NAN);
    let (sources, weights) = assemble(&all, &plan, Activation::Celu, true);
    let output = gathered_mlp(sources, &plan, weights).into_data().try_to_vec::<f32>().unwrap();
    let broken: Vec<bool> = output.chunks(4).map(|row| row.iter().all(|x| x.is_nan())).collect();
    assert_eq!(broken, [false, true, true, false]);
}

#[test]
fn gradients_do_not_depend_on_the_number_of_threads() {
    let plan = GatherPlan::edges(&topology(60, 1500));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let all: Vec<_> =
                inputs(&plan, [32, 32, 8]).into_iter().map(Tensor::require_grad).collect();
            let (sources, weights) = assemble(&all, &plan, Activation::Celu, true);
            let gradients = gathered_mlp(sources, &plan, weights).powi_scalar(2).sum().backward();
            let gradient = |x: &Tensor<2>| {
                x.grad(&gradients).unwrap().into_data().try_to_vec::<f32>().unwrap()
            };
            all.iter().map(gradient).collect::<Vec<_>>()
        })
    };
    assert_eq!(run(1), run(3));
}
