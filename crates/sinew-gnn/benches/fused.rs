//! Time of the fused operations at the size of the thesis' beams, beside their error against
//! plain tensors. One core: `taskset -c 0 env RAYON_NUM_THREADS=1 cargo bench --profile dev -p sinew-burn`.

use burn::optim::{MuonConfig, Optimizer};
use burn::tensor::{Device, Distribution, Tensor};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use rayon::prelude::*;
use sinew_gnn::fused::{
    Activation, EdgeTopology, GatherPlan, Input, LayerNormalisation, PerceptronWeights,
    gathered_mlp, orthogonalise, reference, signed_edge_sum,
};
use std::sync::Arc;

const NODES: usize = 511;
const EDGES: usize = 2960;
const REAL_NODES: usize = 390;
const WIDTH: usize = 128;
const LATENT: usize = 40;
const STEPS: usize = 5;
const HEADS: usize = 3;

type Perceptron = fn(Vec<Input>, &Arc<GatherPlan>, PerceptronWeights) -> Tensor<2>;
type EdgeSum = fn(Tensor<2>, &Arc<EdgeTopology>) -> Tensor<2>;

/// The fused operations, or plain tensors.
#[derive(Clone, Copy)]
struct Kernels {
    perceptron: Perceptron,
    edge_sum: EdgeSum,
}

const FUSED: Kernels = Kernels { perceptron: gathered_mlp, edge_sum: signed_edge_sum };
const PLAIN: Kernels = Kernels {
    perceptron: reference::gathered_mlp,
    edge_sum: |messages, topology| reference::signed_edge_sum(messages, topology),
};

/// Tracked on devices that differentiate.
fn tracked<const D: usize>(x: Tensor<D>) -> Tensor<D> {
    if x.device().is_autodiff() { x.require_grad() } else { x }
}

fn matrix(rows: usize, columns: usize, device: &Device) -> Tensor<2> {
    let bound = (3.0 / rows as f64).sqrt();
    tracked(Tensor::random([rows, columns], Distribution::Uniform(-bound, bound), device))
}

fn features(values: Tensor<2>, first_row: usize) -> Input {
    Input { values, first_row: Some(first_row) }
}

fn perceptron(
    inputs: usize,
    outputs: usize,
    normalised: bool,
    device: &Device,
) -> PerceptronWeights {
    let vector = |size: usize| tracked(Tensor::<1>::zeros([size], device));
    PerceptronWeights {
        activation: Activation::Celu,
        layers: [[inputs, WIDTH], [WIDTH, WIDTH], [WIDTH, outputs]]
            .map(|[rows, columns]| (matrix(rows, columns, device), vector(columns))),
        normalisation: normalised.then(|| LayerNormalisation {
            gain: tracked(Tensor::ones([outputs], device)),
            offset: vector(outputs),
        }),
    }
}

/// Widths of edge, receiver and sender, and of node and sum.
struct Step {
    edge: PerceptronWeights,
    node: PerceptronWeights,
}

struct Processor {
    topology: Arc<EdgeTopology>,
    edges: Arc<GatherPlan>,
    nodes: Arc<GatherPlan>,
    steps: Vec<Step>,
    edge_features: Tensor<2>,
    node_features: Tensor<2>,
}

impl Processor {
    fn new(device: &Device) -> Self {
        let senders: Vec<usize> = (0..EDGES).map(|i| (i * 7 + i / 511) % NODES).collect();
        let receivers: Vec<usize> =
            (0..EDGES).map(|i| (i * 7 + i / 511 + 1 + i % 60) % NODES).collect();
        let topology = EdgeTopology::new(NODES, &senders, &receivers);
        let step = || Step {
            edge: perceptron(3 * LATENT, LATENT, true, device),
            node: perceptron(2 * LATENT, LATENT, true, device),
        };
        Self {
            edges: GatherPlan::edges(&topology),
            nodes: GatherPlan::identity(NODES, 2),
            topology,
            steps: (0..STEPS).map(|_| step()).collect(),
            edge_features: tracked(Tensor::random([EDGES, LATENT], Distribution::Default, device)),
            node_features: tracked(Tensor::random([NODES, LATENT], Distribution::Default, device)),
        }
    }

    fn forward(&self, kernels: Kernels) -> Tensor<2> {
        let (mut v, mut e) = (self.node_features.clone(), self.edge_features.clone());
        for Step { edge, node } in &self.steps {
            let inputs = vec![
                features(e.clone(), 0),
                features(v.clone(), LATENT),
                features(v.clone(), 2 * LATENT),
            ];
            let messages = (kernels.perceptron)(inputs, &self.edges, edge.clone());
            let sums = (kernels.edge_sum)(messages.clone(), &self.topology);
            let inputs = vec![features(v.clone(), 0), features(sums, LATENT)];
            v = v + (kernels.perceptron)(inputs, &self.nodes, node.clone());
            e = e + messages;
        }
        v
    }

    /// Output, and gradients with respect to the node features and a weight of the first step.
    fn step(&self, kernels: Kernels) -> [Tensor<2>; 3] {
        let v = self.forward(kernels);
        let gradients = v.clone().powi_scalar(2).mean().backward();
        let gradient = |x: &Tensor<2>| x.grad(&gradients).expect("tracked");
        [v, gradient(&self.node_features), gradient(&self.steps[0].edge.layers[1].0)]
    }
}

struct Decoder {
    plan: Arc<GatherPlan>,
    nodes: Vec<Tensor<2>>,
    parameters: Vec<Tensor<2>>,
    heads: Vec<PerceptronWeights>,
}

impl Decoder {
    fn new(batch: usize, device: &Device) -> Self {
        let heads = || 0..HEADS;
        let rows = |rows: usize, columns: usize| {
            tracked(Tensor::random([rows, columns], Distribution::Default, device))
        };
        Self {
            plan: GatherPlan::outer(batch, REAL_NODES),
            nodes: heads().map(|_| rows(REAL_NODES, 2 * LATENT)).collect(),
            parameters: heads().map(|_| rows(batch, LATENT)).collect(),
            heads: heads().map(|_| perceptron(3 * LATENT, 1, false, device)).collect(),
        }
    }

    fn forward(&self, kernels: Kernels) -> Tensor<2> {
        let head = |k: usize| {
            let inputs = vec![
                features(self.nodes[k].clone(), LATENT),
                features(self.parameters[k].clone(), 0),
            ];
            (kernels.perceptron)(inputs, &self.plan, self.heads[k].clone())
        };
        Tensor::cat((0..HEADS).map(head).collect(), 1)
    }

    fn step(&self, kernels: Kernels) -> [Tensor<2>; 3] {
        let u = self.forward(kernels);
        let gradients = u.clone().powi_scalar(2).mean().backward();
        let gradient = |x: &Tensor<2>| x.grad(&gradients).expect("tracked");
        [u, gradient(&self.nodes[0]), gradient(&self.heads[1].layers[1].0)]
    }
}

/// Largest difference over value and gradients, relative to the largest number of each.
fn error(found: [Tensor<2>; 3], expected: [Tensor<2>; 3]) -> f32 {
    let relative = |(found, expected): (Tensor<2>, Tensor<2>)| {
        let scale: f32 = expected.clone().abs().max().into_scalar();
        (found - expected).abs().max().into_scalar::<f32>() / scale
    };
    found.into_iter().zip(expected).map(relative).fold(0.0, f32::max)
}

fn message_passing(criterion: &mut Criterion) {
    let device = Device::flex().autodiff();
    device.seed(1);
    let processor = Processor::new(&device);
    eprintln!(
        "message passing: relative error {:.1e}",
        error(processor.step(FUSED), processor.step(PLAIN))
    );
    let mut group = criterion.benchmark_group("message passing, 5 steps");
    let inference = Processor::new(&Device::flex());
    group.bench_function("forward, fused", |b| b.iter(|| inference.forward(FUSED)));
    group.bench_function("forward and backward, fused", |b| b.iter(|| processor.step(FUSED)));
    group.bench_function("forward and backward, plain", |b| b.iter(|| processor.step(PLAIN)));
}

fn decoder(criterion: &mut Criterion) {
    let device = Device::flex().autodiff();
    device.seed(2);
    let mut group = criterion.benchmark_group("decoder, 3 heads");
    for batch in [1, 8, 32, 200] {
        let decoder = Decoder::new(batch, &device);
        let error = error(decoder.step(FUSED), decoder.step(PLAIN));
        eprintln!("decoder at batch {batch}: relative error {error:.1e}");
        group.bench_function(BenchmarkId::new("forward, fused", batch), |b| {
            b.iter(|| decoder.forward(FUSED))
        });
        group.bench_function(BenchmarkId::new("forward and backward, fused", batch), |b| {
            b.iter(|| decoder.step(FUSED));
        });
    }
}

fn muon(criterion: &mut Criterion) {
    let device = Device::flex();
    device.seed(3);
    let mut shapes = vec![[128, 128]; 16];
    shapes.extend([[120, 128]; 15]);
    shapes.extend([[128, 40]; 15]);
    let updates: Vec<Tensor<2>> =
        shapes.iter().map(|&[rows, columns]| matrix(rows, columns, &device)).collect();
    let burn = |update: &Tensor<2>| {
        let optimiser = MuonConfig::new().build();
        optimiser.step::<2>(1.0, update.zeros_like(), update.clone(), None).0
    };
    let numbers = |update: &Tensor<2>| -> (Vec<f32>, usize) {
        let values = update.to_data().try_into_vec().expect("single precision");
        (values, update.dims()[1])
    };
    let updates_of_numbers: Vec<_> = updates.iter().map(numbers).collect();
    let ours = || {
        let mut directions = updates_of_numbers.clone();
        directions.par_iter_mut().for_each(|(values, columns)| orthogonalise(values, *columns));
        directions
    };
    let difference = |((ours, _), update): ((Vec<f32>, usize), &Tensor<2>)| -> f32 {
        let [rows, columns] = update.dims();
        let scale = (rows as f32 / columns as f32).max(1.0).sqrt();
        let pairs = ours.into_iter().zip(numbers(&burn(update)).0);
        pairs.map(|(ours, burn)| (ours * scale + burn).abs()).fold(0.0, f32::max)
    };
    let error = ours().into_iter().zip(&updates).map(difference).fold(0.0, f32::max);
    eprintln!("orthogonalise: largest difference from Burn's {error:.1e}");
    let mut group = criterion.benchmark_group("Newton–Schulz, 46 matrices");
    group.bench_function("ours", |b| b.iter(ours));
    group.bench_function("Burn's", |b| b.iter(|| updates.iter().map(burn).collect::<Vec<_>>()));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(std::time::Duration::from_secs(3)).warm_up_time(std::time::Duration::from_millis(500));
    targets = message_passing, decoder, muon
}
criterion_main!(benches);
