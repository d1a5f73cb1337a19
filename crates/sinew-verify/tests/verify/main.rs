//! The program of the benchmarks, and its references against each other.

mod program;
mod references;
