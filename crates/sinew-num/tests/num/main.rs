//! Numbers of every type, vectors and matrices, connected components, random numbers, threads.

mod connectivity;
mod random;
#[cfg(feature = "threads")]
mod ready;
mod scalars;
mod vectors;
