//! Sparse linear algebra of symmetric stiffness matrices.

mod aggregates;
mod blocks;
pub(crate) mod cholesky;
pub(crate) mod conjugate_gradients;
mod elimination;
mod front;
mod graph;
pub(crate) mod iterative;
mod multigrid;
pub(crate) mod ordering;
#[cfg(test)]
mod samples;
mod separator;
mod trapezoid;
