//! Stiffness of a body, the second derivative of its potential energy.

use crate::Body;

/// Second derivative `∂²Π/∂u²` of cells and springs, in 3 × 3 blocks of neighbouring nodes [stress·length].
///
/// Cartesian, over all nodes, without supports. Pressures are left out, and averaged volume ratios are replaced by
/// those of each point: it is meant for scales and preconditioners, not for Newton's method.
#[derive(Clone, Debug, PartialEq)]
pub struct Stiffness {
    /// Offset of each node's row of blocks, and the end of the last one.
    starts: Vec<usize>,
    /// Node of each block's columns, ascending within a row.
    columns: Vec<usize>,
    blocks: Vec<[[f64; 3]; 3]>,
}

impl Body {
    /// The stiffness at a displacement \[length\]; `None` where a cell is inverted or its energy overflows.
    pub fn stiffness(&self, displacement: &[f64], theta: &[f64]) -> Option<Stiffness> {
        let mut stiffness = Stiffness::zero(self.nodes, self.cell_nodes());
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
            let at = stiffness.block(spring.node, spring.node);
            add(&mut stiffness.blocks[at], &spring.stiffness);
        }
        Some(stiffness)
    }
}

fn add(block: &mut [[f64; 3]; 3], term: &[[f64; 3]; 3]) {
    for i in 0..3 {
        for j in 0..3 {
            block[i][j] += term[i][j];
        }
    }
}

impl Stiffness {
    fn zero<'a>(nodes: usize, cells: impl Iterator<Item = &'a [usize]> + Clone) -> Self {
        let of_cell =
            |cell: &'a [usize]| cell.iter().flat_map(move |&a| cell.iter().map(move |&b| (a, b)));
        let own = (0..nodes).map(|node| (node, node));
        let mut pairs: Vec<(usize, usize)> = cells.flat_map(of_cell).chain(own).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let mut starts = vec![0; nodes + 1];
        pairs.iter().for_each(|&(row, _)| starts[row + 1] += 1);
        (0..nodes).for_each(|node| starts[node + 1] += starts[node]);
        let columns: Vec<usize> = pairs.into_iter().map(|(_, column)| column).collect();
        Self { starts, blocks: vec![[[0.0; 3]; 3]; columns.len()], columns }
    }

    /// Place of the block of two neighbours.
    fn block(&self, row: usize, column: usize) -> usize {
        let start = self.starts[row];
        start + self.columns[start..self.starts[row + 1]].partition_point(|&c| c < column)
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
                let at = self.block(row, column);
                add(&mut self.blocks[at], &term);
            }
        }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.starts.len() - 1
    }

    /// Neighbours of a node, itself among them, each with the forces at the node by the neighbour's displacement.
    pub fn row(&self, node: usize) -> impl Iterator<Item = (usize, &[[f64; 3]; 3])> {
        let range = self.starts[node]..self.starts[node + 1];
        self.columns[range.clone()].iter().copied().zip(&self.blocks[range])
    }

    /// Forces `K u`, written over `forces`.
    pub fn apply(&self, displacement: &[f64], forces: &mut [f64]) {
        let (u, _) = displacement.as_chunks::<3>();
        for (node, force) in forces.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            *force = [0.0; 3];
            for (neighbour, block) in self.row(node) {
                let v = &u[neighbour];
                for i in 0..3 {
                    force[i] += block[i][0] * v[0] + block[i][1] * v[1] + block[i][2] * v[2];
                }
            }
        }
    }
}
