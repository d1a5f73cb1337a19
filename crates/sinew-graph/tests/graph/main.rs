//! Graphs of meshes: augmentation, its promises, features and their statistics.

mod augmentation;
mod clusters;
mod features;
mod invariants;
mod neighbours;
mod sizes;
mod statistics;
mod topology;
