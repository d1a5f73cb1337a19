//! Random distortion of meshes, for patch tests. Included by the tests and studies of other crates, too.

use sinew_mesh::{Mesh, boundary_facets, edges};
use sinew_num::{SplitMix64, cells_of_nodes};
use std::collections::BTreeSet;

/// Least Jacobian after a move \[relative to the original\].
const LEAST_SHARE: f64 = 0.2;
/// Number of times that a move is reversed and halved before the node stays.
const HALVINGS: usize = 6;

/// Meshes with inner nodes that can be moved at random.
pub(crate) trait Distort {
    /// The mesh with its inner nodes moved at random, by up to `amplitude` times the shortest edge at
    /// the node along each axis (triangles within x and y); nodes on the boundary stay. The same seed
    /// gives the same mesh. No cell is inverted: a move that leaves less than a fifth of a Jacobian at a node is
    /// reversed and halved, and given up in the end.
    ///
    /// Middle nodes move as well and curve their cells; for straight cells distort the linear mesh and
    /// then make it quadratic.
    fn distorted(&self, seed: u64, amplitude: f64) -> Self;
}

impl<const N: usize> Distort for Mesh<N> {
    fn distorted(&self, seed: u64, amplitude: f64) -> Self {
        let mut mesh = self.clone();
        let mut random = SplitMix64(seed);
        let stays = BTreeSet::from_iter(self.nodes_of_facets(&boundary_facets(self)));
        let shortest = shortest_edges(self);
        let around = cells_of_nodes(self.points.len(), &self.cells);
        let least: Vec<f64> =
            (0..self.cells.len()).map(|cell| LEAST_SHARE * worst(self, cell)).collect();
        for node in (0..self.points.len()).filter(|node| !stays.contains(node)) {
            let from = mesh.points[node];
            let mut step = amplitude * shortest[node];
            let direction = std::array::from_fn::<f64, 3, _>(|axis| {
                let number = random.number();
                if axis < Self::ELEMENT.dimension { number } else { 0.0 }
            });
            for _ in 0..=HALVINGS {
                mesh.points[node] = std::array::from_fn(|axis| from[axis] + step * direction[axis]);
                if around[node].iter().all(|&cell| worst(&mesh, cell) > least[cell]) {
                    break;
                }
                mesh.points[node] = from;
                step *= -0.5;
            }
        }
        mesh
    }
}

/// The smallest Jacobian at the nodes of a cell.
fn worst<const N: usize>(mesh: &Mesh<N>, cell: usize) -> f64 {
    let at_nodes = Mesh::<N>::ELEMENT.nodes.iter().map(|&at| mesh.jacobian(cell, at));
    at_nodes.fold(f64::INFINITY, f64::min)
}

/// The shortest edge at each node.
fn shortest_edges<const N: usize>(mesh: &Mesh<N>) -> Vec<f64> {
    let mut shortest = vec![f64::INFINITY; mesh.points.len()];
    for [a, b] in edges(mesh) {
        let (p, q) = (mesh.points[a], mesh.points[b]);
        let length = (0..3).map(|axis| (p[axis] - q[axis]).powi(2)).sum::<f64>().sqrt();
        shortest[a] = shortest[a].min(length);
        shortest[b] = shortest[b].min(length);
    }
    // A node without an edge stays.
    shortest.iter_mut().filter(|length| length.is_infinite()).for_each(|length| *length = 0.0);
    shortest
}
