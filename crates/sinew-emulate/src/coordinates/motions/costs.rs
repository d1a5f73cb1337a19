//! Energies of rigid motions, which scale the outputs.

use crate::coordinates::MotionTree;
use nalgebra::{DMatrix, SMatrix, SymmetricEigen};
use sinew_energy::Body;
use sinew_num::sub3;

/// Eigenvalue \[relative to the largest of a cluster's stiffness\] below which a motion has scale zero.
const SMALLEST_STIFFNESS: f64 = 1e-9;

/// Rigid motions of the parts that nodes are divided into: translations, and turns measured by the displacement at the radius of gyration.
struct Parts<'a> {
    /// Part of each node.
    of_nodes: Vec<usize>,
    centres: &'a [[f64; 3]],
    places: &'a [[f64; 3]],
    /// Projector onto the directions that supports leave free, node by node.
    free: &'a [[[f64; 3]; 3]],
    radii: Vec<f64>,
    /// Stiffness of the motions of each part.
    costs: Vec<SMatrix<f64, 6, 6>>,
}

impl<'a> Parts<'a> {
    fn new(
        of_nodes: Vec<usize>,
        centres: &'a [[f64; 3]],
        places: &'a [[f64; 3]],
        free: &'a [[[f64; 3]; 3]],
    ) -> Self {
        let costs = vec![SMatrix::zeros(); centres.len()];
        let mut parts = Self { of_nodes, centres, places, free, radii: Vec::new(), costs };
        let mut sums = vec![(0.0, 0usize); centres.len()];
        for (node, &part) in parts.of_nodes.iter().enumerate() {
            let sum = &mut sums[part];
            *sum = (sum.0 + parts.arm(node).iter().map(|r| r * r).sum::<f64>(), sum.1 + 1);
        }
        let radius = |(squares, count): (f64, usize)| {
            let radius = (squares / count.max(1) as f64).sqrt();
            if radius > 0.0 { radius } else { 1.0 }
        };
        parts.radii = sums.into_iter().map(radius).collect();
        parts
    }

    fn arm(&self, node: usize) -> [f64; 3] {
        sub3(&self.places[node], &self.centres[self.of_nodes[node]])
    }

    /// Displacement of a node by the motions of its part, along what supports leave free. There are some seventeen layers of parts on 100 000
    /// nodes: kept, these would take more memory than the stiffness.
    fn motion(&self, node: usize) -> SMatrix<f64, 3, 6> {
        let radius = self.radii[self.of_nodes[node]];
        matrix(&self.free[node]) * rigid_motions(self.arm(node).map(|r| r / radius))
    }

    /// Adds the stiffness of a quadrature point.
    fn add(&mut self, nodes: &[usize], shape: &[[f64; 3]], tangent: &SMatrix<f64, 9, 9>) {
        let part = |at: usize| self.of_nodes[nodes[at]];
        for first in (0..nodes.len()).filter(|&at| (0..at).all(|other| part(other) != part(at))) {
            let own = (first..nodes.len()).filter(|&at| part(at) == part(first));
            let gradient = own.fold(SMatrix::<f64, 9, 6>::zeros(), |sum, at| {
                let (motion, g) = (self.motion(nodes[at]), &shape[at]);
                sum + SMatrix::from_fn(|row, k| motion[(row / 3, k)] * g[row % 3])
            });
            self.costs[part(first)] += gradient.transpose() * tangent * gradient;
        }
    }
}

/// Gives nodes and clusters of a tree the scales of their motions by the stiffness at a displacement, that of cells and springs: pressures are
/// left out, and averaged volume ratios are replaced by those of each point. `None` where a cell is inverted or its energy overflows.
pub(super) fn scale(
    tree: &mut MotionTree,
    clusters_per_layer: &[usize],
    (body, free): (&Body, &[[[f64; 3]; 3]]),
    (displacement, theta): (&[f64], &[f64]),
) -> Option<()> {
    let mut layers =
        vec![Parts::new((0..body.nodes).collect(), &tree.positions, &tree.positions, free)];
    let mut first = 0;
    for (mut ancestors, &count) in tree.ancestors().into_iter().zip(clusters_per_layer) {
        ancestors.iter_mut().for_each(|cluster| *cluster -= first);
        let centres = &tree.centres[first..first + count];
        layers.push(Parts::new(ancestors, centres, &tree.positions, free));
        first += count;
    }
    let parameters = body.law_parameters(theta);
    for (point, &volume) in body.volumes.iter().enumerate() {
        let h = body.displacement_gradient(point, displacement);
        let response = body.material.response(point, parameters, &h);
        response.energy.is_finite().then_some(())?;
        let tangent = volume * matrix(&response.tangent);
        let (nodes, shape) = (body.nodes_of_point(point), body.shape_of_point(point));
        layers.iter_mut().for_each(|parts| parts.add(nodes, shape, &tangent));
    }
    for parts in &mut layers {
        for spring in &body.springs {
            let size = 3 * spring.nodes.len();
            for (a, &row) in spring.nodes.iter().enumerate() {
                for (b, &column) in spring.nodes.iter().enumerate() {
                    if parts.of_nodes[row] == parts.of_nodes[column] {
                        let entry = |i, j| spring.stiffness[(3 * a + i) * size + 3 * b + j];
                        let block = SMatrix::<f64, 3, 3>::from_fn(entry);
                        let cost = parts.motion(row).transpose() * block * parts.motion(column);
                        parts.costs[parts.of_nodes[row]] += cost;
                    }
                }
            }
        }
    }
    let of_node = |cost: &SMatrix<f64, 6, 6>| inverse_root(cost.fixed_view::<3, 3>(0, 0).into());
    let node_scales = layers[0].costs.iter().map(of_node).collect();
    let clusters = layers[1..].iter().flat_map(|layer| layer.costs.iter().zip(&layer.radii));
    let of_cluster = |(&cost, radius): (&SMatrix<f64, 6, 6>, &f64)| {
        let mut scale = inverse_root(cost);
        scale[3..].as_flattened_mut().iter_mut().for_each(|entry| *entry /= radius);
        scale
    };
    let cluster_scales = clusters.map(of_cluster).collect();
    (tree.node_scales, tree.cluster_scales) = (node_scales, cluster_scales);
    Some(())
}

/// A matrix by its rows.
pub(crate) fn matrix<const N: usize>(rows: &[[f64; N]; N]) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| rows[i][j])
}

/// `|A|^(−½)` on the directions that cost anything.
fn inverse_root<const N: usize>(cost: SMatrix<f64, N, N>) -> [[f64; N]; N] {
    let symmetric = DMatrix::from_fn(N, N, |i, j| 0.5 * (cost[(i, j)] + cost[(j, i)]));
    let root = of_eigenvalues(symmetric, SMALLEST_STIFFNESS, |value| value.abs().powf(-0.5));
    std::array::from_fn(|i| std::array::from_fn(|j| root[(i, j)]))
}

/// A function of a symmetric matrix by that of its eigenvalues, zero for those below a part of the largest.
pub(crate) fn of_eigenvalues(
    symmetric: DMatrix<f64>,
    smallest: f64,
    function: impl Fn(f64) -> f64,
) -> DMatrix<f64> {
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(symmetric);
    let floor = smallest * eigenvalues.amax();
    let function = |value: f64| if value.abs() > floor { function(value) } else { 0.0 };
    &eigenvectors * DMatrix::from_diagonal(&eigenvalues.map(function)) * eigenvectors.transpose()
}

/// Displacement of a node by translations and small turns about a place so far from it.
pub(crate) fn rigid_motions([x, y, z]: [f64; 3]) -> SMatrix<f64, 3, 6> {
    SMatrix::from_row_slice(&[
        1.0, 0.0, 0.0, 0.0, z, -y, //
        0.0, 1.0, 0.0, -z, 0.0, x, //
        0.0, 0.0, 1.0, y, -x, 0.0,
    ])
}
