//! Energies of rigid motions, which scale the outputs.

use crate::coordinates::MotionTree;
use nalgebra::{DMatrix, SMatrix, SymmetricEigen};
use sinew_energy::Stiffness;
use sinew_num::sub3;

/// Eigenvalue \[relative to the largest of a cluster's stiffness\] below which a motion has scale zero.
const SMALLEST_STIFFNESS: f64 = 1e-9;

/// Energies of motions of nodes and of clusters.
pub(super) struct Costs<'a> {
    pub stiffness: &'a Stiffness,
    /// Projector onto the free directions of each node.
    pub free: &'a [[[f64; 3]; 3]],
    pub places: &'a [[f64; 3]],
}

impl Costs<'_> {
    pub(super) fn of_node(&self, node: usize) -> SMatrix<f64, 3, 3> {
        let own = self.stiffness.row(node).find(|(neighbour, _)| *neighbour == node);
        let block = own.map_or([[0.0; 3]; 3], |(_, block)| *block);
        let (free, block) = (matrix(&self.free[node]), matrix(&block));
        free * block * free
    }

    /// Gives every cluster of a tree its scale, layer by layer.
    pub(super) fn scale_clusters(&self, tree: &mut MotionTree, roots_per_layer: &[usize]) {
        let mut first = 0;
        for (ancestors, &count) in tree.ancestors().iter().zip(roots_per_layer) {
            let of_layer = self.of_clusters(ancestors, first..first + count, &tree.centres);
            tree.cluster_scales.extend(of_layer.into_iter().map(|(cost, radius)| {
                let mut scale = inverse_root(cost);
                scale[3..].as_flattened_mut().iter_mut().for_each(|entry| *entry /= radius);
                scale
            }));
            first += count;
        }
    }

    /// Translations, and turns measured by the displacement at the radius of gyration, of each cluster of a layer, and
    /// that radius. `ancestors` are the clusters of the nodes.
    fn of_clusters(
        &self,
        ancestors: &[usize],
        layer: std::ops::Range<usize>,
        centres: &[[f64; 3]],
    ) -> Vec<(SMatrix<f64, 6, 6>, f64)> {
        let mut sums = vec![(0.0, 0usize); layer.len()];
        let arm = |node: usize| sub3(&self.places[node], &centres[ancestors[node]]);
        for (node, &cluster) in ancestors.iter().enumerate() {
            let sum = &mut sums[cluster - layer.start];
            *sum = (sum.0 + arm(node).iter().map(|r| r * r).sum::<f64>(), sum.1 + 1);
        }
        let radius = |&(squares, count): &(f64, usize)| {
            let radius = (squares / count.max(1) as f64).sqrt();
            if radius > 0.0 { radius } else { 1.0 }
        };
        let mut costs: Vec<_> =
            sums.iter().map(|sum| (SMatrix::<f64, 6, 6>::zeros(), radius(sum))).collect();
        let rigid = |node: usize, radius: f64| {
            matrix(&self.free[node]) * rigid_motions(arm(node).map(|r| r / radius))
        };
        for (node, &cluster) in ancestors.iter().enumerate() {
            let (cost, radius) = &mut costs[cluster - layer.start];
            let mut force = SMatrix::<f64, 3, 6>::zeros();
            for (neighbour, block) in self.stiffness.row(node) {
                if ancestors[neighbour] == cluster {
                    force += matrix(block) * rigid(neighbour, *radius);
                }
            }
            *cost += rigid(node, *radius).transpose() * force;
        }
        costs
    }
}

/// A matrix by its rows.
pub(crate) fn matrix<const N: usize>(rows: &[[f64; N]; N]) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| rows[i][j])
}

/// `|A|^(−½)` on the directions that cost anything.
pub(super) fn inverse_root<const N: usize>(cost: SMatrix<f64, N, N>) -> [[f64; N]; N] {
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
