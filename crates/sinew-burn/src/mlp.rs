//! The fused perceptron as an operation of Burn.

use std::sync::Arc;

use burn::tensor::{DType, Tensor};

use crate::activation::Activation;
use crate::host::{HostOperation, HostTensor, apply};
use crate::index::GatherPlan;
use crate::mlp_backward::backward;
use crate::mlp_kernel::{Activations, Parameters, forward};
use crate::normalise::Normalisation;
use crate::reference;

/// Hidden activations of an evaluation are kept for the backward pass up to this many bytes, and
/// computed again beyond it: then they would have to come back from main memory.
const KEPT_BYTES: usize = 16 << 20;

/// A perceptron with two hidden layers, after the products of its first layer:
/// `x ↦ N(f(f(x + b₁) W₂ + b₂) W₃ + b₃)` with N the normalisation, if any.
#[derive(Clone, Debug)]
pub struct PerceptronTail {
    /// Activation f of both hidden layers.
    pub activation: Activation,
    /// b₁, `[h]`.
    pub first_bias: Tensor<1>,
    /// W₂, `[h, h']`.
    pub second_weight: Tensor<2>,
    /// b₂, `[h']`.
    pub second_bias: Tensor<1>,
    /// W₃, `[h', m]`.
    pub third_weight: Tensor<2>,
    /// b₃, `[m]`.
    pub third_bias: Tensor<1>,
    /// Layer normalisation of the output.
    pub normalisation: Option<LayerNormalisation>,
}

/// Normalisation of every row to mean zero and variance one, then `gain · x + offset`.
#[derive(Clone, Debug)]
pub struct LayerNormalisation {
    /// `[m]`.
    pub gain: Tensor<1>,
    /// `[m]`.
    pub offset: Tensor<1>,
    /// Added to the variance.
    pub epsilon: f64,
}

/// Evaluates a perceptron on sums of gathered rows as one operation:
/// row `r` of the result, `[rows, m]`, is `tail(Σ_k sources[k][index_k(r)])` with the indices of `plan`.
///
/// The sources, `[rows of source k, h]`, hold the products of the first layer's weight with each
/// part of its input, computed once per source row instead of once per result row:
/// edges ([`GatherPlan::edges`]) add their own row and those of receiver and sender, a batched
/// decoder ([`GatherPlan::outer`]) the row of a node and that of a parameter, and
/// [`GatherPlan::identity`] covers the rest. [`reference::gathered_mlp`] is the same in plain
/// tensors; it is used for anything but single precision.
///
/// Gradients do not depend on the number of threads.
///
/// ```
/// use burn::tensor::{Device, Tensor};
/// use sinew_burn::{Activation, GatherPlan, PerceptronTail, gathered_mlp};
///
/// let device = Device::flex();
/// let tail = PerceptronTail {
///     activation: Activation::Celu,
///     first_bias: Tensor::zeros([2], &device),
///     second_weight: Tensor::from_floats([[1.0, 0.0], [0.0, 1.0]], &device),
///     second_bias: Tensor::zeros([2], &device),
///     third_weight: Tensor::from_floats([[1.0], [1.0]], &device),
///     third_bias: Tensor::zeros([1], &device),
///     normalisation: None,
/// };
/// // Two nodes and three parameters: six rows.
/// let nodes = Tensor::from_floats([[1.0, 0.0], [2.0, 0.0]], &device);
/// let parameters = Tensor::from_floats([[0.0, 1.0], [0.0, 2.0], [0.0, 3.0]], &device);
/// let y = gathered_mlp(vec![nodes, parameters], &GatherPlan::outer(3, 2), tail);
/// assert_eq!(y.into_data().try_to_vec::<f32>().unwrap(), [2.0, 3.0, 3.0, 4.0, 4.0, 5.0]);
/// ```
///
/// # Panics
/// When the shapes of sources, plan and parameters disagree.
pub fn gathered_mlp(
    sources: Vec<Tensor<2>>,
    plan: &Arc<GatherPlan>,
    tail: PerceptronTail,
) -> Tensor<2> {
    check_shapes(&sources, plan, &tail);
    let single = |tensor: &Tensor<2>| tensor.dtype() == DType::F32;
    if !sources.iter().all(single) || !single(&tail.second_weight) || tail.widths().contains(&0) {
        return reference::gathered_mlp(sources, plan, tail);
    }
    let operation = GatheredMlp {
        plan: plan.clone(),
        activation: tail.activation,
        epsilon: tail.normalisation.as_ref().map(|normalisation| normalisation.epsilon as f32),
    };
    let mut inputs: Vec<_> = sources.into_iter().map(Tensor::into_dispatch).collect();
    inputs.extend([
        tail.first_bias.into_dispatch(),
        tail.second_weight.into_dispatch(),
        tail.second_bias.into_dispatch(),
        tail.third_weight.into_dispatch(),
        tail.third_bias.into_dispatch(),
    ]);
    if let Some(LayerNormalisation { gain, offset, .. }) = tail.normalisation {
        inputs.extend([gain.into_dispatch(), offset.into_dispatch()]);
    }
    apply(operation, inputs)
}

impl PerceptronTail {
    fn widths(&self) -> [usize; 3] {
        [self.first_bias.dims()[0], self.second_bias.dims()[0], self.third_bias.dims()[0]]
    }
}

fn check_shapes(sources: &[Tensor<2>], plan: &GatherPlan, tail: &PerceptronTail) {
    let [first, second, outputs] = tail.widths();
    assert_eq!(sources.len(), plan.source_rows().len(), "the plan's number of sources");
    for (source, rows) in sources.iter().zip(plan.source_rows()) {
        assert_eq!(
            source.dims(),
            [*rows, first],
            "a source must be [rows of the plan, width of first bias]"
        );
    }
    assert_eq!(tail.second_weight.dims(), [first, second], "second weight against the biases");
    assert_eq!(tail.third_weight.dims(), [second, outputs], "third weight against the biases");
    if let Some(LayerNormalisation { gain, offset, .. }) = &tail.normalisation {
        assert_eq!(
            [gain.dims()[0], offset.dims()[0]],
            [outputs; 2],
            "gain and offset against the output"
        );
    }
}

#[derive(Clone, Debug)]
struct GatheredMlp {
    plan: Arc<GatherPlan>,
    activation: Activation,
    /// Of the normalisation, if there is one.
    epsilon: Option<f32>,
}

/// What the backward pass needs: parameters, and activations or the sources to repeat them from.
#[derive(Clone, Debug)]
struct Saved {
    sources: Vec<HostTensor>,
    parameters: Vec<HostTensor>,
    activations: Option<Arc<Activations>>,
}

impl GatheredMlp {
    fn parameters<'a>(&self, tensors: &'a [HostTensor]) -> Parameters<'a> {
        Parameters {
            activation: self.activation,
            first_bias: tensors[0].values(),
            second_weight: tensors[1].values(),
            second_bias: tensors[2].values(),
            third_weight: tensors[3].values(),
            third_bias: tensors[4].values(),
            normalisation: self.epsilon.map(|epsilon| Normalisation {
                gain: tensors[5].values(),
                offset: tensors[6].values(),
                epsilon,
            }),
        }
    }
}

impl HostOperation for GatheredMlp {
    type Saved = Saved;

    fn forward(&self, inputs: &[HostTensor], tracked: bool) -> (HostTensor, Option<Saved>) {
        let (sources, tensors) = inputs.split_at(self.plan.source_rows().len());
        let parameters = self.parameters(tensors);
        let (first, second) = (parameters.first_bias.len(), parameters.second_bias.len());
        let keep = tracked && self.plan.rows() * (first + second) * size_of::<f32>() <= KEPT_BYTES;
        let values: Vec<&[f32]> = sources.iter().map(HostTensor::values).collect();
        let (output, activations) = forward(&self.plan, &values, &parameters, keep);
        let output = HostTensor::new(output, [self.plan.rows(), parameters.third_bias.len()]);
        let saved = tracked.then(|| Saved {
            sources: if keep { Vec::new() } else { sources.to_vec() },
            parameters: tensors.to_vec(),
            activations: activations.map(Arc::new),
        });
        (output, saved)
    }

    fn backward(&self, saved: Saved, cotangent: &[f32], needed: &[bool]) -> Vec<Option<Vec<f32>>> {
        let parameters = self.parameters(&saved.parameters);
        let sources: Vec<&[f32]> = saved.sources.iter().map(HostTensor::values).collect();
        let activations = saved.activations.as_deref();
        let gradients = backward(&self.plan, &sources, &parameters, activations, cotangent, needed);
        gradients.sources.into_iter().chain(gradients.parameters.into_iter().map(Some)).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use burn::tensor::Tensor;

    use super::{LayerNormalisation, PerceptronTail, gathered_mlp};
    use crate::testing::{Comparison, device, random};
    use crate::{Activation, EdgeTopology, GatherPlan, reference};

    /// Sources first, then the parameters; vectors as matrices of one row.
    fn inputs(plan: &GatherPlan, [first, second, outputs]: [usize; 3]) -> Vec<Tensor<2>> {
        let device = device();
        let mut inputs: Vec<_> = plan
            .source_rows()
            .iter()
            .enumerate()
            .map(|(k, &rows)| random([rows, first], k as u64, &device))
            .collect();
        let scaled =
            |shape: [usize; 2], seed| random(shape, seed, &device) / (shape[0] as f64).sqrt();
        inputs.extend([
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
    ) -> (Vec<Tensor<2>>, PerceptronTail) {
        let (sources, p) = inputs.split_at(plan.source_rows().len());
        let vector = |i: usize| p[i].clone().flatten::<1>(0, 1);
        let normalisation = normalised.then(|| LayerNormalisation {
            gain: vector(5),
            offset: vector(6),
            epsilon: 1e-6,
        });
        let tail = PerceptronTail {
            activation,
            first_bias: vector(0),
            second_weight: p[1].clone(),
            second_bias: vector(2),
            third_weight: p[3].clone(),
            third_bias: vector(4),
            normalisation,
        };
        (sources.to_vec(), tail)
    }

    fn compare(
        plan: &Arc<GatherPlan>,
        widths: [usize; 3],
        activation: Activation,
        normalised: bool,
    ) {
        let mut all = inputs(plan, widths);
        if !normalised {
            all.truncate(all.len() - 2);
        }
        Comparison::of(all).assert_close(
            |x| {
                let (sources, tail) = assemble(x, plan, activation, normalised);
                gathered_mlp(sources, plan, tail)
            },
            |x| {
                let (sources, tail) = assemble(x, plan, activation, normalised);
                reference::gathered_mlp(sources, plan, tail)
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
            let plan = GatherPlan::identity(131, sources).unwrap();
            compare(&plan, [20, 12, 6], Activation::Celu, true);
            compare(&plan, [20, 12, 6], Activation::Celu, false);
        }
    }

    #[test]
    fn single_outputs_over_an_outer_plan_agree_with_plain_tensors() {
        compare(&GatherPlan::outer(5, 61), [32, 32, 1], Activation::Celu, false);
        compare(&GatherPlan::outer(1, 7), [32, 32, 1], Activation::Tanh, false);
    }

    #[test]
    fn recomputed_activations_give_the_same_gradients() {
        // 17 MB of activations: more than is kept.
        compare(&GatherPlan::outer(20, 850), [128, 128, 1], Activation::Celu, false);
        compare(&GatherPlan::outer(20, 850), [128, 128, 12], Activation::Celu, true);
    }

    #[test]
    fn no_rows_give_no_output_and_zero_gradients() {
        let plan = GatherPlan::identity(0, 1).unwrap();
        let all: Vec<_> = inputs(&plan, [8, 8, 4]).into_iter().map(Tensor::require_grad).collect();
        let (sources, tail) = assemble(&all, &plan, Activation::Celu, true);
        let output = gathered_mlp(sources, &plan, tail);
        assert_eq!(output.dims(), [0, 4]);
        let gradients = output.sum().backward();
        let weight = all[2].grad(&gradients).unwrap().into_data().try_to_vec::<f32>().unwrap();
        assert_eq!(weight, [0.0; 64]);
    }

    #[test]
    fn not_a_number_reaches_exactly_the_rows_that_read_it() {
        let plan = GatherPlan::indexed(&[&[0, 1, 1, 0]], &[2]).unwrap();
        let mut all = inputs(&plan, [8, 8, 4]);
        all[0] = all[0].clone().slice_fill([1..2, 3..4], f32::NAN);
        let (sources, tail) = assemble(&all, &plan, Activation::Celu, true);
        let output = gathered_mlp(sources, &plan, tail).into_data().try_to_vec::<f32>().unwrap();
        let broken: Vec<bool> =
            output.chunks(4).map(|row| row.iter().all(|x| x.is_nan())).collect();
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
                let (sources, tail) = assemble(&all, &plan, Activation::Celu, true);
                let gradients = gathered_mlp(sources, &plan, tail).powi_scalar(2).sum().backward();
                let gradient = |x: &Tensor<2>| {
                    x.grad(&gradients).unwrap().into_data().try_to_vec::<f32>().unwrap()
                };
                all.iter().map(gradient).collect::<Vec<_>>()
            })
        };
        assert_eq!(run(1), run(3));
    }
}
