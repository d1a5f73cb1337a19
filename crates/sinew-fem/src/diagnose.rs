//! Diagnoses of a solution: report, locking, error estimate, free parts, stresses.

pub(crate) mod error_estimate;
pub(crate) mod hinges;
pub(crate) mod locking;
pub(crate) mod named;
pub(crate) mod report;
pub(crate) mod rigid;
pub(crate) mod stress;
