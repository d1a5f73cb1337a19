//! The two implementations of the emulator's inner operations.

use crate::fused::{Activation, reference};
#[cfg(any(feature = "wgpu", feature = "cuda"))]
use burn::backend::DispatchDevice;
use burn::tensor::{Device, Tensor};

use crate::graph::Graph;

/// Implementation of the emulator's operations; both use the same parameters and agree to rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KernelChoice {
    /// Plain Burn operations, the reference of the tests.
    Reference,
    /// Fused operations of [`fused`](crate::fused).
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

impl Kernels {
    pub(crate) fn activate<const D: usize>(&self, x: Tensor<D>) -> Tensor<D> {
        match self.choice {
            KernelChoice::Fused => crate::fused::activate(x, self.activation),
            KernelChoice::Reference => reference::activate(x, self.activation),
        }
    }

    /// Derivative of the activation, from the activation's value.
    pub(crate) fn slope_of_active<const D: usize>(&self, active: Tensor<D>) -> Tensor<D> {
        match self.activation {
            Activation::Tanh => 1.0 - active.clone() * active,
            Activation::Celu => active.clamp_max(0.0) + 1.0,
        }
    }

    /// Sum of two tensors of one shape.
    pub(crate) fn sum(&self, a: Tensor<2>, b: Tensor<2>) -> Tensor<2> {
        match self.choice {
            KernelChoice::Fused => crate::fused::sum(a, b),
            KernelChoice::Reference => a + b,
        }
    }

    /// Received minus sent messages at every node (2.27).
    pub(crate) fn signed_sum(&self, graph: &Graph, messages: Tensor<2>) -> Tensor<2> {
        match self.choice {
            KernelChoice::Fused => crate::fused::signed_edge_sum(messages, &graph.edges),
            KernelChoice::Reference => reference::signed_edge_sum(messages, &graph.edges),
        }
    }

    /// Sum of the stored edges received at every node.
    pub(crate) fn received_sum(&self, graph: &Graph, edges: Tensor<2>) -> Tensor<2> {
        match self.choice {
            KernelChoice::Fused => crate::fused::received_edge_sum(edges, &graph.edges),
            KernelChoice::Reference => reference::received_edge_sum(edges, &graph.edges),
        }
    }
}
