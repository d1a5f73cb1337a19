//! The two implementations of the emulator's inner operations.

use burn::tensor::Tensor;

use crate::config::Activation;

/// How the emulator computes; both ways use the same parameters and agree to rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum KernelChoice {
    /// Plain Burn operations: runs on every backend, the reference of the tests.
    Reference,
    /// Fused operations of `sinew-burn`.
    #[default]
    Fused,
}

/// A choice of kernels and the activation they apply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Kernels {
    pub choice: KernelChoice,
    pub activation: Activation,
}

impl Kernels {
    pub fn activate<const D: usize>(&self, x: Tensor<D>) -> Tensor<D> {
        match self.activation {
            Activation::Tanh => x.tanh(),
            Activation::Celu => celu(x),
        }
    }

    /// Derivative of the activation, from the activation's value.
    pub fn slope_of_active<const D: usize>(&self, active: Tensor<D>) -> Tensor<D> {
        match self.activation {
            Activation::Tanh => 1.0 - active.clone() * active,
            Activation::Celu => active.clamp_max(0.0) + 1.0,
        }
    }
}

/// `max(0, x) + min(0, eˣ − 1)`.
fn celu<const D: usize>(x: Tensor<D>) -> Tensor<D> {
    x.clone().clamp_min(0.0) + (x.clamp_max(0.0).exp() - 1.0)
}
