//! Diagnoses of a solution: reactions, locking, error estimate, free parts, stresses.

pub(crate) mod error_estimate;
pub(crate) mod locking;
pub(crate) mod rigid;
pub(crate) mod stress;
