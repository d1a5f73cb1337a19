//! The fused perceptron as an operation of Burn.

use crate::fused::activation::Activation;
use crate::fused::host::{HostTensor, Pullback, apply, is_on_host};
use crate::fused::index::GatherPlan;
use crate::fused::mlp_backward::backward;
use crate::fused::mlp_kernel::{Parameters, Source, forward};
use crate::fused::normalise::Normalisation;
use crate::fused::perceptron::{Input, LayerNormalisation, PerceptronWeights};
use crate::fused::reference;
use burn::tensor::Tensor;
use std::sync::Arc;

/// Hidden activations of an evaluation are kept for the backward pass up to this many bytes, and
/// computed again beyond it, so that memory stays bounded.
const KEPT_BYTES: usize = 64 << 20;

/// Evaluates a perceptron on gathered rows as one operation: row `r` of the result, `[rows, m]`,
/// is that of the input whose part `k` is row `index_k(r)` of `inputs[k]`, with the indices of
/// `plan`.
///
/// A part that serves several rows meets the first weight once per row of its own: edges
/// ([`GatherPlan::edges`]) concatenate their features with those of receiver and sender, a
/// batched decoder ([`GatherPlan::outer`]) those of a node and of a parameter set, and
/// [`GatherPlan::identity`] covers the rest. [`reference::gathered_mlp`] is the same in plain
/// tensors; it is used on graphics processors, and for anything but single precision.
///
/// Gradients do not depend on the number of threads.
///
/// ```
/// use burn::tensor::{Device, Tensor};
/// use sinew_gnn::fused::{Activation, GatherPlan, Input, PerceptronWeights, gathered_mlp};
///
/// let device = Device::flex();
/// let weights = PerceptronWeights {
///     activation: Activation::Celu,
///     layers: [
///         (Tensor::from_floats([[1.0, 0.0], [0.0, 1.0]], &device), Tensor::zeros([2], &device)),
///         (Tensor::from_floats([[1.0, 0.0], [0.0, 1.0]], &device), Tensor::zeros([2], &device)),
///         (Tensor::from_floats([[1.0], [1.0]], &device), Tensor::zeros([1], &device)),
///     ],
///     normalisation: None,
/// };
/// // Two nodes and three parameters: six rows.
/// let features = |values, first_row| Input { values, first_row: Some(first_row) };
/// let nodes = features(Tensor::from_floats([[1.0], [2.0]], &device), 0);
/// let parameters = features(Tensor::from_floats([[1.0], [2.0], [3.0]], &device), 1);
/// let y = gathered_mlp(vec![nodes, parameters], &GatherPlan::outer(3, 2), weights);
/// assert_eq!(y.into_data().try_to_vec::<f32>().unwrap(), [2.0, 3.0, 3.0, 4.0, 4.0, 5.0]);
/// ```
///
/// # Panics
/// When the shapes of inputs, plan and weights disagree, or for more than three inputs.
pub fn gathered_mlp(
    inputs: Vec<Input>,
    plan: &Arc<GatherPlan>,
    weights: PerceptronWeights,
) -> Tensor<2> {
    check_shapes(&inputs, plan, &weights);
    let are_on_host = inputs.iter().all(|input| is_on_host(&input.values));
    if !are_on_host || !is_on_host(&weights.layers[1].0) || weights.widths().contains(&0) {
        return reference::gathered_mlp(inputs, plan, weights);
    }
    let operation = GatheredMlp {
        plan: plan.clone(),
        activation: weights.activation,
        first_rows: inputs.iter().map(|input| input.first_row).collect(),
    };
    let mut tensors: Vec<_> =
        inputs.into_iter().map(|input| input.values.into_dispatch()).collect();
    for (weight, bias) in weights.layers {
        tensors.extend([weight.into_dispatch(), bias.into_dispatch()]);
    }
    if let Some(LayerNormalisation { gain, offset }) = weights.normalisation {
        tensors.extend([gain.into_dispatch(), offset.into_dispatch()]);
    }
    apply(tensors, move |inputs, tracked| operation.evaluate(inputs, tracked))
}

impl PerceptronWeights {
    fn widths(&self) -> [usize; 3] {
        self.layers.each_ref().map(|(_, bias)| bias.dims()[0])
    }
}

fn check_shapes(inputs: &[Input], plan: &GatherPlan, weights: &PerceptronWeights) {
    let [first, second, outputs] = weights.widths();
    let [[meeting, width], hidden @ ..] =
        weights.layers.each_ref().map(|(weight, _)| weight.dims());
    assert_eq!(width, first, "first weight against its bias");
    assert_eq!(hidden, [[first, second], [second, outputs]], "later weights against the biases");
    assert_eq!(inputs.len(), plan.sources.len(), "the plan's number of sources");
    for (input, (_, rows)) in inputs.iter().zip(&plan.sources) {
        let [found, columns] = input.values.dims();
        assert_eq!(found, *rows, "rows of an input against the plan");
        match input.first_row {
            Some(row) => assert!(row + columns <= meeting, "an input beyond the first weight"),
            None => assert_eq!(columns, first, "a product against the first bias"),
        }
    }
    if let Some(LayerNormalisation { gain, offset }) = &weights.normalisation {
        let found = [gain.dims()[0], offset.dims()[0]];
        assert_eq!(found, [outputs; 2], "gain and offset against the output");
    }
}

#[derive(Clone)]
struct GatheredMlp {
    plan: Arc<GatherPlan>,
    activation: Activation,
    /// Per input, see `first_row` of [`Input`].
    first_rows: Vec<Option<usize>>,
}

impl GatheredMlp {
    fn sources<'a>(&'a self, tensors: &'a [HostTensor]) -> Vec<Source<'a>> {
        let gathers = self.plan.sources.iter().zip(&self.first_rows);
        tensors
            .iter()
            .zip(gathers)
            .map(|(tensor, ((gather, _), &first_row))| Source {
                values: tensor.values(),
                width: tensor.shape()[1],
                gather,
                first_row,
            })
            .collect()
    }

    /// Parameters among the tensors, after the inputs.
    fn parameters<'a>(&self, tensors: &'a [HostTensor]) -> Parameters<'a> {
        let tensors = &tensors[self.first_rows.len()..];
        Parameters {
            activation: self.activation,
            weights: std::array::from_fn(|layer| tensors[2 * layer].values()),
            biases: std::array::from_fn(|layer| tensors[2 * layer + 1].values()),
            normalisation: tensors
                .get(6)
                .map(|gain| Normalisation { gain: gain.values(), offset: tensors[7].values() }),
        }
    }

    /// Whether each hidden layer is kept. The first is cheap to repeat where nothing is multiplied in tiles.
    fn keep(&self, sources: &[Source<'_>], parameters: &Parameters<'_>) -> [bool; 2] {
        let [first, second, _] = parameters.widths();
        let in_tiles = sources.iter().any(Source::is_multiplied_in_tiles);
        let width = if in_tiles { first + second } else { second };
        let second = self.plan.rows * width * size_of::<f32>() <= KEPT_BYTES;
        [second && in_tiles, second]
    }

    /// The output, and the derivative; activations are kept where it is `tracked`.
    fn evaluate(&self, inputs: &[HostTensor], tracked: bool) -> (HostTensor, Pullback) {
        let (sources, parameters) = (self.sources(inputs), self.parameters(inputs));
        let keep = if tracked { self.keep(&sources, &parameters) } else { [false; 2] };
        let (output, activations) = forward(&self.plan, &sources, &parameters, keep);
        let output = HostTensor::new(output, [self.plan.rows, parameters.widths()[2]]);
        let (operation, tensors) = (self.clone(), inputs.to_vec());
        let pullback = Pullback::new(move |cotangent, needed| {
            let sources = operation.sources(&tensors);
            let parameters = operation.parameters(&tensors);
            let needed = &needed[..sources.len()];
            backward(&operation.plan, &sources, &parameters, &activations, cotangent, needed)
        });
        (output, pullback)
    }
}
