//! Numbers of every type, vectors and matrices, connected components, random numbers, threads.

mod connectivity;
#[cfg(feature = "threads")]
mod parallel;
mod random;
#[cfg(feature = "threads")]
mod ready;
mod scalars;
mod vectors;
