//! Sparse matrices, orders, factors and iterations of the linear systems.

pub(crate) mod aggregation;
pub(crate) mod factor;
pub(crate) mod krylov;
pub(crate) mod ordering;
pub(crate) mod sparsity;
pub(crate) mod systems;
pub(crate) mod vector;

pub(crate) use aggregation::{Aggregation, MOST_ITERATIONS, Shifted};
pub(crate) use factor::{Factor, MOST_SHIFTS, shift_of};
pub(crate) use krylov::{
    End, Iterated, LinearOutcome, conjugate_gradients, gmres, largest, update,
};
pub(crate) use ordering::fill_reducing_order;
pub(crate) use sparsity::{Sparsity, facets_of, patch_nodes_of};
pub(crate) use systems::{MOST_COUNTED, MOST_SINGLE, Method};
pub(crate) use vector::{add, compressed, difference, dot, norm, relative};
