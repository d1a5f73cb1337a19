//! Quick runs of the studies: the same code as the full ones, on small meshes with few steps; the benchmarks' references against each other.

mod beams;
mod gp;
mod organs;
mod populations;
mod references;
mod thesis;
mod verify;
