//! Sparse matrices, orders, factors and iterations of the linear systems.

pub(crate) mod aggregation;
pub(crate) mod conjugate_gradients;
pub(crate) mod factor;
pub(crate) mod gmres;
pub(crate) mod method;
pub(crate) mod ordering;
pub(crate) mod sparsity;
pub(crate) mod systems;
pub(crate) mod vector;
