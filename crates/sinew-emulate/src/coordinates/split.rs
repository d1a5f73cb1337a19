//! Split of a change of the displacement over the clusters.

use crate::coordinates::{
    Dirichlet, MotionTree, Motions, Result, matrix, of_eigenvalues, require_count, rigid_motions,
};
use nalgebra::{DMatrix, SMatrix, SVector};
use sinew_num::sub3;

/// Eigenvalue \[relative to the largest\] below which an output has no effect.
const SMALLEST: f64 = 1e-10;

/// Displacement of a node.
type Place = SVector<f64, 3>;

impl Motions {
    /// Outputs of clusters and then of nodes that make small changes of the displacement \[length\]: from the whole body down,
    /// each cluster moves as near to what its nodes still lack as it can (least squares), and nodes do the rest.
    pub(crate) fn outputs_of(
        &self,
        changes: &[Vec<f64>],
        dirichlet: &Dirichlet,
    ) -> Result<Vec<Vec<f64>>> {
        let tree = self.tree();
        let (nodes, clusters) = (tree.positions.len(), tree.centres.len());
        let table = dirichlet.projectors(3);
        let free: Vec<SMatrix<f64, 3, 3>> =
            table.chunks_exact(9).map(SMatrix::from_row_slice).collect();
        let layers: Vec<Layer> =
            tree.ancestors().into_iter().map(|of| Layer::new(tree, of, &free)).collect();
        let own = |node: usize| {
            let scale = free[node] * matrix(&tree.node_scales[node]);
            pseudo_inverse(scale.transpose() * scale) * scale.transpose()
        };
        let own: Vec<SMatrix<f64, 3, 3>> = (0..nodes).map(own).collect();
        let outputs = |change: &Vec<f64>| {
            require_count("entries of a change", change.len(), 3 * nodes)?;
            let rows = change.chunks_exact(3).zip(&free);
            let mut rest: Vec<Place> =
                rows.map(|(u, free)| free * Place::from_column_slice(u)).collect();
            let mut outputs = vec![0.0; 6 * clusters];
            layers.iter().rev().for_each(|layer| layer.take(&mut rest, &mut outputs));
            let of_nodes = rest.iter().zip(&own).map(|(rest, own)| own * rest);
            outputs.extend(of_nodes.flat_map(|y| [y[0], y[1], y[2]]));
            Ok(outputs)
        };
        changes.iter().map(outputs).collect()
    }
}

/// Clusters that share no node.
struct Layer {
    /// The cluster of every node.
    of: Vec<usize>,
    /// Displacement of every node by the outputs of its cluster.
    motions: Vec<SMatrix<f64, 3, 6>>,
    /// Inverses of the sums of `motionᵀ motion` over the nodes of every cluster; zero for those of other layers.
    inverses: Vec<SMatrix<f64, 6, 6>>,
}

impl Layer {
    fn new(tree: &MotionTree, of: Vec<usize>, free: &[SMatrix<f64, 3, 3>]) -> Self {
        let motion = |(node, &cluster): (usize, &usize)| {
            let arm = sub3(&tree.positions[node], &tree.centres[cluster]);
            free[node] * rigid_motions(arm) * matrix(&tree.cluster_scales[cluster])
        };
        let motions: Vec<SMatrix<f64, 3, 6>> = of.iter().enumerate().map(motion).collect();
        let mut inverses = vec![SMatrix::<f64, 6, 6>::zeros(); tree.centres.len()];
        for (&cluster, motion) in of.iter().zip(&motions) {
            inverses[cluster] += motion.transpose() * motion;
        }
        let inverse = |sum: SMatrix<f64, 6, 6>| match sum.amax() > 0.0 {
            true => pseudo_inverse(sum),
            false => sum,
        };
        Self { of, motions, inverses: inverses.into_iter().map(inverse).collect() }
    }

    /// Sets the outputs of the clusters by least squares, and subtracts their motion from `rest`.
    fn take(&self, rest: &mut [Place], outputs: &mut [f64]) {
        let mut moved = vec![SVector::<f64, 6>::zeros(); self.inverses.len()];
        for ((&cluster, motion), rest) in self.of.iter().zip(&self.motions).zip(&*rest) {
            moved[cluster] += motion.transpose() * rest;
        }
        for (moved, inverse) in moved.iter_mut().zip(&self.inverses) {
            *moved = inverse * *moved;
        }
        for ((&cluster, motion), rest) in self.of.iter().zip(&self.motions).zip(rest) {
            *rest -= motion * moved[cluster];
            outputs[6 * cluster..6 * cluster + 6].copy_from_slice(moved[cluster].as_slice());
        }
    }
}

fn pseudo_inverse<const N: usize>(square: SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    let square = DMatrix::from_column_slice(N, N, square.as_slice());
    let inverse = of_eigenvalues(square, SMALLEST, |value| 1.0 / value);
    SMatrix::from_fn(|i, j| inverse[(i, j)])
}
