//! Fused perceptrons against plain tensors.

use super::comparison::{Comparison, device, evaluate, random};
use burn::tensor::{DType, Tensor};
use sinew_gnn::fused::{
    Activation, EdgeTopology, GatherPlan, Input, LayerNormalisation, PerceptronWeights,
    gathered_mlp, reference,
};
use std::sync::Arc;

/// Width of every input that is multiplied with the first weight.
const FEATURES: usize = 9;

/// A plan, and the rows of its sources.
struct Gathered {
    plan: Arc<GatherPlan>,
    rows: Vec<usize>,
}

impl Gathered {
    fn edges(topology: &EdgeTopology) -> Self {
        let [nodes, edges] = topology.size();
        Self { plan: GatherPlan::edges(topology), rows: vec![edges, nodes, nodes] }
    }

    fn identity(rows: usize, sources: usize) -> Self {
        Self { plan: GatherPlan::identity(rows, sources), rows: vec![rows; sources] }
    }

    fn outer(outer: usize, inner: usize) -> Self {
        Self { plan: GatherPlan::outer(outer, inner), rows: vec![inner, outer] }
    }

    fn and_shared(mut self) -> Self {
        self.rows.push(1);
        Self { plan: self.plan.and_shared(), rows: self.rows }
    }
}

/// Inputs first, then the parameters; vectors as matrices of one row. The last input is a
/// product already if there are several.
fn inputs(gathered: &Gathered, [first, second, outputs]: [usize; 3]) -> Vec<Tensor<2>> {
    let device = device();
    let sources = gathered.rows.len();
    let width = |k: usize| if k > 0 && k + 1 == sources { first } else { FEATURES };
    let mut inputs: Vec<_> = gathered
        .rows
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
    gathered: &Gathered,
    activation: Activation,
    normalised: bool,
) -> (Vec<Input>, PerceptronWeights) {
    let (sources, p) = inputs.split_at(gathered.rows.len());
    let vector = |i: usize| p[i].clone().flatten::<1>(0, 1);
    let normalisation =
        normalised.then(|| LayerNormalisation { gain: vector(6), offset: vector(7) });
    let layers = std::array::from_fn(|k| (p[2 * k].clone(), vector(2 * k + 1)));
    let weights = PerceptronWeights { activation, layers, normalisation };
    let input = |(k, values): (usize, &Tensor<2>)| match k > 0 && k + 1 == sources.len() {
        true => Input { values: values.clone(), first_row: None },
        // In another order than that of the inputs.
        false => {
            Input { values: values.clone(), first_row: Some((sources.len() - 1 - k) * FEATURES) }
        }
    };
    (sources.iter().enumerate().map(input).collect(), weights)
}

fn fused(
    inputs: &[Tensor<2>],
    gathered: &Gathered,
    activation: Activation,
    normalised: bool,
) -> Tensor<2> {
    let (sources, weights) = assemble(inputs, gathered, activation, normalised);
    gathered_mlp(sources, &gathered.plan, weights)
}

fn compare(gathered: &Gathered, widths: [usize; 3], activation: Activation, normalised: bool) {
    Comparison::of(inputs_of(gathered, widths, normalised)).assert_close(
        |x| fused(x, gathered, activation, normalised),
        |x| {
            let (sources, weights) = assemble(x, gathered, activation, normalised);
            reference::gathered_mlp(sources, &gathered.plan, weights)
        },
    );
}

/// [`inputs`] with gain and offset only where they are read.
fn inputs_of(gathered: &Gathered, widths: [usize; 3], normalised: bool) -> Vec<Tensor<2>> {
    let mut all = inputs(gathered, widths);
    all.truncate(all.len() - if normalised { 0 } else { 2 });
    all
}

/// A weight of 1 or 2 for each column, which makes no sum of whole numbers inexact.
fn whole_weights(output: &Tensor<2>) -> Tensor<2> {
    let columns = (0..output.dims()[1]).map(|j| 1.0 + (j % 2) as f32).collect::<Vec<_>>();
    let row = Tensor::<1>::from_floats(&columns[..], &output.device()).unsqueeze::<2>();
    row.cast(output.dtype())
}

fn topology(nodes: usize, edges: usize) -> Arc<EdgeTopology> {
    let senders: Vec<usize> = (0..edges).map(|i| (i * 7 + 3) % nodes).collect();
    let receivers: Vec<usize> = (0..edges).map(|i| (i * i + 5 * i) % nodes).collect();
    EdgeTopology::new(nodes, &senders, &receivers)
}

#[test]
fn edges_agree_with_plain_tensors() {
    let edges = Gathered::edges(&topology(60, 300));
    compare(&edges, [32, 24, 10], Activation::Celu, true);
    compare(&edges, [33, 17, 5], Activation::Tanh, true);
    compare(&edges, [16, 16, 4], Activation::Celu, false);
}

#[test]
fn full_width_over_many_groups_agrees_with_plain_tensors() {
    compare(&Gathered::edges(&topology(200, 1500)), [128, 128, 40], Activation::Celu, true);
}

#[test]
fn identity_sources_agree_with_plain_tensors() {
    for sources in 1..=3 {
        let rows = Gathered::identity(131, sources);
        compare(&rows, [20, 12, 6], Activation::Celu, true);
        compare(&rows, [20, 12, 6], Activation::Celu, false);
    }
}

#[test]
fn single_outputs_over_an_outer_plan_agree_with_plain_tensors() {
    compare(&Gathered::outer(5, 61), [32, 32, 1], Activation::Celu, false);
    compare(&Gathered::outer(5, 61).and_shared(), [32, 32, 1], Activation::Celu, false);
    compare(&Gathered::outer(1, 7), [32, 32, 1], Activation::Tanh, false);
}

#[test]
fn an_outer_plan_pairs_every_row() {
    // A perceptron that passes positive numbers on.
    let device = device();
    let layers = [(); 3].map(|()| (Tensor::eye(2, &device), Tensor::zeros([2], &device)));
    let weights = PerceptronWeights { activation: Activation::Celu, layers, normalisation: None };
    let inner = Tensor::from_floats([[1.0], [2.0], [3.0]], &device);
    let outer = Tensor::from_floats([[10.0], [20.0]], &device);
    let sources = vec![
        Input { values: inner, first_row: Some(0) },
        Input { values: outer, first_row: Some(1) },
    ];
    let pairs = gathered_mlp(sources, &GatherPlan::outer(2, 3), weights);
    assert_eq!(
        pairs.into_data().try_to_vec::<f32>().unwrap(),
        [1.0, 10.0, 2.0, 10.0, 3.0, 10.0, 1.0, 20.0, 2.0, 20.0, 3.0, 20.0]
    );
}

/// Small whole numbers, so that sums are exact in any order: products of all shapes, and their transposes in the gradients.
#[test]
fn perceptrons_of_whole_numbers_are_exact() {
    let whole = |[rows, columns]: [usize; 2], seed: usize| {
        let number = |i: usize| ((i * 7 + i / 5 + seed) % 3) as f32;
        let numbers: Vec<f32> = (0..rows * columns).map(number).collect();
        Tensor::<1>::from_floats(&numbers[..], &device()).reshape([rows, columns])
    };
    for [rows, features, first, second, outputs] in [
        [1, 1, 1, 1, 2],
        [7, 3, 40, 5, 2],
        [13, 128, 128, 128, 3],
        [6, 40, 64, 40, 64],
        [11, 5, 79, 17, 33],
        [25, 17, 97, 33, 5],
        [4, 2, 33, 97, 1],
    ] {
        let all = [
            whole([rows, features], 1),
            whole([features, first], 2),
            whole([1, first], 3),
            whole([first, second], 4),
            whole([1, second], 5),
            whole([second, outputs], 6),
            whole([1, outputs], 7),
        ];
        let plan = GatherPlan::identity(rows, 1);
        let parts = |x: &[Tensor<2>]| {
            let vector = |i: usize| x[i].clone().flatten::<1>(0, 1);
            let layers = std::array::from_fn(|k| (x[2 * k + 1].clone(), vector(2 * k + 2)));
            let weights =
                PerceptronWeights { activation: Activation::Celu, layers, normalisation: None };
            (vec![Input { values: x[0].clone(), first_row: Some(0) }], weights)
        };
        let found = |x: &[Tensor<2>]| {
            let (input, weights) = parts(x);
            gathered_mlp(input, &plan, weights)
        };
        let expected = |x: &[Tensor<2>]| {
            let (input, weights) = parts(x);
            reference::gathered_mlp(input, &plan, weights)
        };
        let double = all.each_ref().map(|x| x.clone().cast(DType::F64));
        assert_eq!(
            evaluate(&all, &found, &whole_weights),
            evaluate(&double, &expected, &whole_weights),
            "{rows} rows, widths {features}, {first}, {second}, {outputs}"
        );
    }
}

/// Hidden activations of so many rows take more than 64 MiB and are computed again; those of half of them are kept.
#[test]
fn recomputed_activations_give_the_same_gradients() {
    /// Recursive sums of n = 270 000 rows in single precision lose between √n u = 3e-5 and n u = 2e-2 of the largest number of a tensor;
    /// activations that are not those of their rows would change it wholly.
    const SUMMED: f64 = 1e-3;
    for (whole, half, widths, normalised) in [
        (Gathered::outer(600, 450), Gathered::outer(300, 450), [24, 64, 1], false),
        (Gathered::identity(270_000, 1), Gathered::identity(135_000, 1), [24, 40, 4], true),
    ] {
        let all = inputs_of(&whole, widths, normalised);
        let is_split = |k: usize| k < half.rows.len() && half.rows[k] < whole.rows[k];
        let part = |number: usize| {
            let part = |(k, x): (usize, &Tensor<2>)| match is_split(k) {
                true => x.clone().slice_dim(0, number * half.rows[k]..(number + 1) * half.rows[k]),
                false => x.clone(),
            };
            let inputs: Vec<_> = all.iter().enumerate().map(part).collect();
            let function = |x: &[Tensor<2>]| fused(x, &half, Activation::Celu, normalised);
            evaluate(&inputs, &function, &whole_weights)
        };
        let function = |x: &[Tensor<2>]| fused(x, &whole, Activation::Celu, normalised);
        let found = evaluate(&all, &function, &whole_weights);
        for (number, (first, second)) in part(0).into_iter().zip(part(1)).enumerate() {
            // The output comes first; rows of the halves follow each other, other gradients are sums.
            let expected = match number == 0 || is_split(number - 1) {
                true => [first, second].concat(),
                false => first.iter().zip(&second).map(|(a, b)| a + b).collect(),
            };
            assert_eq!(found[number].len(), expected.len());
            let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for (found, expected) in found[number].iter().zip(&expected) {
                let error = (found - expected).abs();
                assert!(error <= SUMMED * largest, "result {number}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn no_rows_give_no_output_and_zero_gradients() {
    let none = Gathered::identity(0, 1);
    let all: Vec<_> = inputs(&none, [8, 8, 4]).into_iter().map(Tensor::require_grad).collect();
    let output = fused(&all, &none, Activation::Celu, true);
    assert_eq!(output.dims(), [0, 4]);
    let gradients = output.sum().backward();
    let weight = all[3].grad(&gradients).unwrap().into_data().try_to_vec::<f32>().unwrap();
    assert_eq!(weight, [0.0; 64]);
}

#[test]
fn not_a_number_reaches_exactly_the_rows_that_read_it() {
    // Features of receivers are the second source, those of senders the third.
    let edges = Gathered::edges(&EdgeTopology::new(3, &[1, 2, 0, 1], &[0, 1, 1, 2]));
    for (source, expected) in [(1, [false, true, true, false]), (2, [true, false, false, true])] {
        let mut all = inputs(&edges, [8, 8, 4]);
        all[source] = all[source].clone().slice_fill([1..2, 3..4], f32::NAN);
        let output = fused(&all, &edges, Activation::Celu, true);
        let output = output.into_data().try_to_vec::<f32>().unwrap();
        let broken = |row: &[f32]| row.iter().all(|x| x.is_nan());
        assert!(output.chunks(4).map(broken).eq(expected), "{output:?}");
    }
}

/// Scratch memory is handed on from operation to operation with what it holds.
#[test]
fn scratch_memory_leaves_no_trace() {
    let edges = Gathered::edges(&topology(60, 300));
    let all = inputs(&edges, [32, 24, 10]);
    let function = |x: &[Tensor<2>]| fused(x, &edges, Activation::Celu, true);
    let expected = evaluate(&all, &function, &whole_weights);
    let broken: Vec<_> = all.iter().map(|x| x.clone() * f32::NAN).collect();
    let output = evaluate(&broken, &function, &whole_weights).remove(0);
    assert!(output.iter().all(|x| x.is_nan()));
    assert_eq!(evaluate(&all, &function, &whole_weights), expected);
}

#[test]
fn gradients_do_not_depend_on_the_number_of_threads() {
    let edges = Gathered::edges(&topology(60, 1500));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let all: Vec<_> =
                inputs(&edges, [32, 32, 8]).into_iter().map(Tensor::require_grad).collect();
            let output = fused(&all, &edges, Activation::Celu, true);
            let gradients = output.powi_scalar(2).sum().backward();
            let gradient = |x: &Tensor<2>| {
                x.grad(&gradients).unwrap().into_data().try_to_vec::<f32>().unwrap()
            };
            all.iter().map(gradient).collect::<Vec<_>>()
        })
    };
    assert_eq!(run(1), run(3));
}
