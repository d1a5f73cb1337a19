//! Posterior of u and of the parameters: at one set of parameters, and over draws of them.

mod answer;
pub(crate) mod conditional;
pub(crate) mod ensemble;
pub(crate) mod laplace;
pub(crate) mod nuts;
pub(crate) mod space;
