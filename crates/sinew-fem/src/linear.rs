//! Sparse linear algebra of symmetric stiffness matrices.

pub(crate) mod cholesky;
mod elimination;
mod front;
mod graph;
pub(crate) mod ordering;
#[cfg(test)]
mod samples;
mod separator;
mod trapezoid;
