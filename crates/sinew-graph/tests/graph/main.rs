//! Graphs of meshes: augmentation, its promises, features and their statistics.

mod augmentation;
mod clusters;
mod features;
mod invariants;
mod neighbours;
mod sizes;
mod statistics;
mod topology;

use sinew_graph::{Topology, pool_positions};

/// Mean squared distance of the mesh nodes from their roots, which k-means minimises.
fn inertia(topology: &Topology, positions: &[[f64; 3]]) -> f64 {
    let places = pool_positions(topology, positions).unwrap();
    let squared = |(x, root): (&[f64; 3], &usize)| -> f64 {
        let mean = places[topology.real_nodes + root];
        (0..3).map(|i| (x[i] - mean[i]).powi(2)).sum()
    };
    let squares = positions.iter().zip(&topology.clusters[0]).map(squared);
    squares.sum::<f64>() / positions.len() as f64
}
