//! Sparse linear algebra of symmetric stiffness matrices.

mod graph;
pub(crate) mod ordering;
mod separator;
