//! The fused operations in plain Burn operations: slower, for every backend and precision, and
//! the oracle of the tests.

use crate::fused::index::{Gather, Index};
use crate::fused::normalise::VARIANCE_FLOOR;
use crate::fused::{
    Activation, EdgeTopology, GatherPlan, Input, LayerNormalisation, PerceptronWeights,
};
use burn::tensor::{Device, IndexingUpdateOp, Int, Tensor};
use std::sync::Arc;

/// `activation` of every number.
pub fn activate<const D: usize>(x: Tensor<D>, activation: Activation) -> Tensor<D> {
    match activation {
        // Unlike `burn::tensor::activation::celu`, whose slope is 0 · ∞ where eˣ overflows.
        Activation::Celu => {
            let positive = x.clone().greater_scalar(0.0);
            let curved = x.clone().mask_fill(positive.clone(), 0.0).exp() - 1.0;
            curved.mask_where(positive, x)
        }
        Activation::Tanh => x.tanh(),
    }
}

/// Per node, the sum of received messages minus the sum of sent ones.
pub fn signed_edge_sum(messages: Tensor<2>, topology: &EdgeTopology) -> Tensor<2> {
    let received = received_edge_sum(messages.clone(), topology);
    received - sum_at(messages, &topology.senders, topology.nodes)
}

/// Per node, the sum of received messages.
pub fn received_edge_sum(messages: Tensor<2>, topology: &EdgeTopology) -> Tensor<2> {
    sum_at(messages, &topology.receivers, topology.nodes)
}

fn sum_at(messages: Tensor<2>, index: &Index, count: usize) -> Tensor<2> {
    let device = messages.device();
    let zeros = Tensor::zeros([count, messages.dims()[1]], (&device, messages.dtype()));
    zeros.select_assign(0, targets(index, &device), messages, IndexingUpdateOp::Add)
}

fn targets(index: &Index, device: &Device) -> Tensor<1, Int> {
    let targets: Vec<i64> = index.targets.iter().map(|&target| target.into()).collect();
    Tensor::from_data(&targets[..], device)
}

/// A perceptron on gathered rows; see [`crate::fused::gathered_mlp`].
pub fn gathered_mlp(
    inputs: Vec<Input>,
    plan: &Arc<GatherPlan>,
    weights: PerceptronWeights,
) -> Tensor<2> {
    let [(weight, bias), hidden @ ..] = weights.layers;
    let mut output = bias.unsqueeze::<2>();
    for (number, Input { values, first_row }) in inputs.into_iter().enumerate() {
        let product = match first_row {
            None => values,
            Some(row) => {
                let rows = row..row + values.dims()[1];
                values.matmul(weight.clone().slice_dim(0, rows))
            }
        };
        output = output + gathered(product, plan, number);
    }
    for (weight, bias) in hidden {
        output = activate(output, weights.activation).matmul(weight) + bias.unsqueeze();
    }
    match weights.normalisation {
        Some(normalisation) => normalised(output, normalisation),
        None => output,
    }
}

/// The rows of source `number` that the rows of a plan's result read.
fn gathered(source: Tensor<2>, plan: &GatherPlan, number: usize) -> Tensor<2> {
    match plan.sources[number].0 {
        Gather::Identity => source,
        Gather::Cyclic { period } => source.repeat_dim(0, plan.rows / period.max(1)),
        Gather::Repeated { times } => {
            let [rows, width] = source.dims();
            source.unsqueeze_dim::<3>(1).repeat_dim(1, times).reshape([rows * times, width])
        }
        Gather::Indexed(ref index) => selected(source, index),
    }
}

/// Rows of `table` that an index refers to.
pub(crate) fn selected(table: Tensor<2>, index: &Index) -> Tensor<2> {
    let rows = targets(index, &table.device());
    table.select(0, rows)
}

/// Mean of `√(‖row‖² + floor)` over the rows of `x`.
pub fn mean_norm(x: Tensor<3>, floor: f32) -> Tensor<1> {
    ((x.clone() * x).sum_dim(2) + floor).sqrt().mean()
}

/// Rows of mean zero and variance one, times gain plus offset.
pub fn normalised(x: Tensor<2>, normalisation: LayerNormalisation) -> Tensor<2> {
    let deviation = x.clone() - x.mean_dim(1);
    let variance = (deviation.clone() * deviation.clone()).mean_dim(1);
    let normal = deviation / (variance + VARIANCE_FLOOR).sqrt();
    normal * normalisation.gain.unsqueeze() + normalisation.offset.unsqueeze()
}
