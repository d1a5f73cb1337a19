//! A perceptron and what it is fed.

use crate::fused::activation::Activation;
use burn::tensor::Tensor;

/// Weights of a perceptron with two hidden layers,
/// `x ↦ N(f(f(x W₁ + b₁) W₂ + b₂) W₃ + b₃)` with N the normalisation, if any.
#[derive(Clone, Debug)]
pub struct PerceptronWeights {
    /// Activation f of both hidden layers.
    pub activation: Activation,
    /// W₁ `[inputs, h]` and b₁ `[h]`, W₂ `[h, h']` and b₂ `[h']`, W₃ `[h', m]` and b₃ `[m]`.
    pub layers: [(Tensor<2>, Tensor<1>); 3],
    /// Layer normalisation of the output.
    pub normalisation: Option<LayerNormalisation>,
}

/// Normalisation of every row to mean zero and variance one, to which 1e-6 is added, then `gain · x + offset`.
#[derive(Clone, Debug)]
pub struct LayerNormalisation {
    /// `[m]`.
    pub gain: Tensor<1>,
    /// `[m]`.
    pub offset: Tensor<1>,
}

/// One part of a perceptron's input.
#[derive(Clone, Debug)]
pub struct Input {
    /// Numbers that the first weight multiplies, `[rows, d]`, or products with it that were formed before, `[rows, h]`.
    pub values: Tensor<2>,
    /// First of the rows of W₁ that multiply them; none for products.
    pub first_row: Option<usize>,
}
