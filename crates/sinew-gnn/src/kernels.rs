//! The two implementations of the emulator's inner operations.

use std::sync::Arc;

#[cfg(any(feature = "wgpu", feature = "cuda"))]
use burn::backend::DispatchDevice;
use burn::tensor::{Device, Tensor};
use sinew_burn::{GatherPlan, Input};

use crate::config::Activation;
use crate::graph::GraphTensors;

/// How the emulator computes; both ways use the same parameters and agree to rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KernelChoice {
    /// Plain Burn operations, the reference of the tests.
    Reference,
    /// Fused operations of `sinew-burn`; perceptrons of other than two hidden layers use plain ones.
    #[default]
    Fused,
}

impl KernelChoice {
    /// The faster ones on a device: fused operations work in the memory of the processor, so that a graphics
    /// processor would wait for its tensors to go there and back.
    pub(crate) fn on(device: &Device) -> Self {
        match device.clone().without_autodiff().as_dispatch() {
            #[cfg(any(feature = "wgpu", feature = "cuda"))]
            DispatchDevice::Cube(_) => Self::Reference,
            _ => Self::Fused,
        }
    }
}

/// A choice of kernels and the activation they apply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Kernels {
    pub choice: KernelChoice,
    pub activation: Activation,
}

impl From<Activation> for sinew_burn::Activation {
    fn from(activation: Activation) -> Self {
        match activation {
            Activation::Celu => Self::Celu,
            Activation::Tanh => Self::Tanh,
        }
    }
}

impl Kernels {
    pub(crate) fn activate<const D: usize>(&self, x: Tensor<D>) -> Tensor<D> {
        match (self.choice, self.activation) {
            (KernelChoice::Fused, activation) => sinew_burn::activate(x, activation.into()),
            (KernelChoice::Reference, Activation::Tanh) => x.tanh(),
            (KernelChoice::Reference, Activation::Celu) => {
                x.clone().clamp_min(0.0) + (x.clamp_max(0.0).exp() - 1.0)
            }
        }
    }

    /// Derivative of the activation, from the activation's value.
    pub(crate) fn slope_of_active<const D: usize>(&self, active: Tensor<D>) -> Tensor<D> {
        match self.activation {
            Activation::Tanh => 1.0 - active.clone() * active,
            Activation::Celu => active.clamp_max(0.0) + 1.0,
        }
    }

    /// Of two tensors of one shape.
    pub(crate) fn sum(&self, a: Tensor<2>, b: Tensor<2>) -> Tensor<2> {
        match self.choice {
            KernelChoice::Fused => sinew_burn::sum(a, b),
            KernelChoice::Reference => a + b,
        }
    }

    /// Received minus sent messages at every node (2.27).
    pub(crate) fn signed_sum(&self, graph: &GraphTensors, messages: Tensor<2>) -> Tensor<2> {
        match self.choice {
            KernelChoice::Fused => sinew_burn::signed_edge_sum(messages, &graph.edges),
            KernelChoice::Reference => graph.signed_sum(messages),
        }
    }

    /// Sum of the stored edges received at every node.
    pub(crate) fn received_sum(&self, graph: &GraphTensors, edges: Tensor<2>) -> Tensor<2> {
        match self.choice {
            KernelChoice::Fused => sinew_burn::received_edge_sum(edges, &graph.edges),
            KernelChoice::Reference => graph.received_sum(edges),
        }
    }
}

/// Which rows of a perceptron's inputs meet in which row of its hidden layers.
pub(crate) enum Rows<'a> {
    /// Row by row.
    Aligned,
    /// A row per edge, and rows per node read at the receiver and at the sender.
    Edges(&'a GraphTensors),
    /// Every row of the second source with every row of the first, the second slower; a third
    /// source has one row, which all read.
    EveryPair,
}

impl Rows<'_> {
    /// The sum of the sources, in plain tensors.
    pub(crate) fn sum(&self, sources: Vec<Tensor<2>>) -> Option<Tensor<2>> {
        let mut sources = sources.into_iter();
        match self {
            Self::Aligned => sources.reduce(|sum, source| sum + source),
            Self::Edges(graph) => {
                let (own, receiver, sender) = (sources.next()?, sources.next()?, sources.next()?);
                Some(own + graph.at_receivers(receiver) + graph.at_senders(sender))
            }
            Self::EveryPair => {
                let (inner, outer) = (sources.next()?, sources.next()?);
                let outer = sources.fold(outer, |sum, shared| sum + shared);
                let ([rows, width], copies) = (inner.dims(), outer.dims()[0]);
                let pairs = inner.unsqueeze_dim::<3>(0) + outer.unsqueeze_dim::<3>(1);
                Some(pairs.reshape([copies * rows, width]))
            }
        }
    }

    /// The same for the fused kernel; `None` where it has no such plan.
    pub(crate) fn plan(&self, inputs: &[Input]) -> Option<Arc<GatherPlan>> {
        let rows = |input: usize| inputs.get(input).map(Input::rows);
        match self {
            Self::Aligned => GatherPlan::identity(rows(0)?, inputs.len()).ok(),
            Self::Edges(graph) => Some(graph.plan.clone()),
            Self::EveryPair => {
                let plan = GatherPlan::outer(rows(1)?, rows(0)?);
                if inputs.len() > 2 { plan.and_shared().ok() } else { Some(plan) }
            }
        }
    }
}
