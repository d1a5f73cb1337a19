//! The fused operations beside plain tensors and plain sums.

mod activations;
mod comparison;
mod edges;
mod lanes;
mod orthogonal;
mod perceptrons;
mod potentials;
mod products;
mod rows;
mod trees;

pub(crate) use products::by_plain_sums;
