//! Stiffness of a body, the second derivative of its potential energy.

use crate::Body;
use std::collections::BTreeMap;

/// Second derivative `∂²Π/∂u²` of cells and springs, in 3 × 3 blocks of neighbouring nodes [stress·length].
///
/// Cartesian, over all nodes, without supports. Pressures are left out, and averaged volume ratios are replaced by
/// those of each point: it is meant for scales and preconditioners, not for Newton's method.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stiffness {
    /// Blocks by the nodes of their rows and columns.
    blocks: BTreeMap<(usize, usize), [[f64; 3]; 3]>,
}

impl Body {
    /// The stiffness at a displacement \[length\]; `None` where a cell is inverted or its energy overflows.
    pub fn stiffness(&self, displacement: &[f64], theta: &[f64]) -> Option<Stiffness> {
        let mut stiffness = Stiffness::default();
        let parameters = self.law_parameters(theta);
        for (point, &volume) in self.volumes.iter().enumerate() {
            let h = self.displacement_gradient(point, displacement);
            let response = self.material.response(point, parameters, &h);
            if !response.energy.is_finite() {
                return None;
            }
            let (nodes, shape) = (self.nodes_of_point(point), self.shape_of_point(point));
            stiffness.add_cell(nodes, shape, volume, &response.tangent);
        }
        for spring in &self.springs {
            stiffness.add((spring.node, spring.node), &spring.stiffness);
        }
        Some(stiffness)
    }
}

impl Stiffness {
    fn add(&mut self, at: (usize, usize), term: &[[f64; 3]; 3]) {
        let block = self.blocks.entry(at).or_default();
        for i in 0..3 {
            for j in 0..3 {
                block[i][j] += term[i][j];
            }
        }
    }

    fn add_cell(
        &mut self,
        nodes: &[usize],
        shape: &[[f64; 3]],
        volume: f64,
        tangent: &[[f64; 9]; 9],
    ) {
        for (&row, g) in nodes.iter().zip(shape) {
            // Forces at this node by a change of the displacement gradient.
            let force: [[f64; 9]; 3] = std::array::from_fn(|i| {
                std::array::from_fn(|kl| {
                    volume * (0..3).map(|j| g[j] * tangent[3 * i + j][kl]).sum::<f64>()
                })
            });
            for (&column, g) in nodes.iter().zip(shape) {
                let term = force.map(|force| {
                    std::array::from_fn(|k| (0..3).map(|l| force[3 * k + l] * g[l]).sum())
                });
                self.add((row, column), &term);
            }
        }
    }

    /// Neighbours of a node, itself among them, each with the forces at the node by the neighbour's displacement.
    pub fn row(&self, node: usize) -> impl Iterator<Item = (usize, &[[f64; 3]; 3])> {
        let row = self.blocks.range((node, 0)..(node + 1, 0));
        row.map(|(&(_, neighbour), block)| (neighbour, block))
    }
}
