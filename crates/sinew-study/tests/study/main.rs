//! Quick runs of the studies: the same code as the full ones, on small meshes with few steps.

mod beams;
mod organs;
mod populations;
mod thesis;
