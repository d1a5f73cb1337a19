//! Burn tensors as numbers of a mechanical formula, and fused autodiff operations.
//!
//! A graph-network emulator spends its time in small perceptrons on gathered rows. Here each is
//! one operation of Burn's autodiff graph, tiled for the cache and vectorised:
//!
//! ```
//! use burn::tensor::{Device, Tensor};
//! use sinew_gnn::fused::{Activation, EdgeTopology, activate, signed_edge_sum};
//!
//! // A path of three nodes; each edge carries one message.
//! let topology = EdgeTopology::new(3, &[0, 1], &[1, 2]);
//! let device = Device::flex().autodiff();
//! let messages = Tensor::<2>::from_floats([[1.0], [-2.0]], &device).require_grad();
//!
//! let sums = signed_edge_sum(activate(messages.clone(), Activation::Celu), &topology);
//! assert_eq!(sums.dims(), [3, 1]);
//! let gradient = messages.grad(&sums.powi_scalar(2).sum().backward()).unwrap();
//! assert_eq!(gradient.dims(), [2, 1]);
//! ```
//!
//! - [`gathered_mlp`]: a perceptron on gathered rows;
//! - [`signed_edge_sum`], [`received_edge_sum`]: messages to nodes;
//! - [`activate`]: activations of all numbers;
//! - [`sum`], [`concatenated`], [`normalised`]: of two tensors, of several, of rows;
//! - [`mean_distance`]: of rows from given ones;
//! - [`orthogonalise`]: the Newton–Schulz iteration of the Muon optimiser, in place;
//! - [`adam_direction`], [`momentum_direction`]: moments of gradients, in place;
//! - [`fused_potential`]: an energy from outside of Burn whose backward pass is its residual.
//!
//! Every operation has its double in plain tensors in [`mod@reference`], which it agrees with to
//! single-precision rounding, and which stands in for it in other precisions and on graphics
//! processors. All are deterministic, whatever the number of threads.
// The ndarray backend is deprecated upstream; it is wired up here as long as Burn has it.
#![cfg_attr(feature = "ndarray", allow(deprecated))]

mod activation;
mod edges;
mod host;
mod index;
mod mlp;
mod mlp_backward;
mod mlp_kernel;
mod moments;
mod normalise;
mod perceptron;
mod plain;
mod pool;
mod product;
pub mod reference;
mod rows;
mod simd;

pub use activation::Activation;
pub(crate) use edges::selected;
pub use edges::{EdgeTopology, received_edge_sum, signed_edge_sum};
pub(crate) use host::{HostTensor, Pullback, apply};
pub use index::GatherPlan;
pub(crate) use index::Index;
pub use mlp::gathered_mlp;
pub(crate) use moments::squared_norm;
pub use moments::{AdamRule, adam_direction, descend, momentum_direction, orthogonalise};
pub(crate) use normalise::VARIANCE_FLOOR;
pub use perceptron::{Input, LayerNormalisation, PerceptronWeights};
pub use plain::{activate, concatenated, fused_potential, mean_distance, normalised, sum};
pub use sinew_num::on_ready_threads;
