//! Diagnostics of chains and weights, and files of chains.

mod arviz;
mod mixing;
