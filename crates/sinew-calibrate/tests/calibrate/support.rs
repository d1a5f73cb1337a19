//! Hearts and differences that the tests share.

pub(crate) mod heart;
pub(crate) mod slopes;
