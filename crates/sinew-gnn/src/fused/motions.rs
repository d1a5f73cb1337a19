//! Rigid motions of nested clusters on tensors.

use crate::fused::host::{HostOperation, HostTensor, apply};
use burn::tensor::{DType, Tensor};
use rayon::prelude::*;
use sinew_emulate::coordinates::MotionTree;
use std::sync::Arc;

/// Displacements `[samples, nodes, 3]` of outputs `[samples, clusters, 6]` and `[samples, nodes, 3]`.
///
/// Inside everything is double precision and only differences from the place of rest are formed, so that displacements
/// small beside the body keep their digits. Samples are spread over threads.
///
/// ```
/// use std::sync::Arc;
/// use burn::tensor::{Device, Tensor};
/// use sinew_gnn::fused::rigid_motions;
/// use sinew_emulate::coordinates::MotionTree;
///
/// // Two nodes in one cluster that turns about its centre by a right angle.
/// let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let tree = Arc::new(MotionTree {
///     node_parents: vec![0, 0],
///     cluster_parents: vec![None],
///     positions: vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
///     centres: vec![[0.0; 3]],
///     node_scales: vec![identity; 2],
///     cluster_scales: vec![std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))))],
/// });
/// let turn = std::f32::consts::FRAC_PI_2;
/// let clusters = Tensor::<3>::from_floats([[[0.0, 0.0, 0.0, 0.0, 0.0, turn]]], &Device::flex());
/// let nodes = Tensor::<3>::zeros([1, 2, 3], &Device::flex());
/// let u = rigid_motions(clusters, nodes, &tree).into_data().try_to_vec::<f32>()?;
/// for (found, expected) in u.iter().zip([1.0, -1.0, 0.0, -1.0, 1.0, 0.0]) {
///     assert!((found - expected).abs() < 1e-6);
/// }
/// # Ok::<(), burn::tensor::DataError>(())
/// ```
///
/// # Panics
/// When outputs and tree disagree in their numbers.
pub fn rigid_motions(clusters: Tensor<3>, nodes: Tensor<3>, tree: &Arc<MotionTree>) -> Tensor<3> {
    let dtype = nodes.dtype();
    let single = |x: Tensor<3>| if x.dtype() == DType::F32 { x } else { x.cast(DType::F32) };
    let inputs = [single(clusters), single(nodes)].map(Tensor::into_dispatch);
    let displacement = apply(Motions(tree.clone()), inputs.into());
    if dtype == DType::F32 { displacement } else { displacement.cast(dtype) }
}

fn write(values: &[f64], to: &mut [f32]) {
    to.iter_mut().zip(values).for_each(|(to, value)| *to = *value as f32);
}

fn widen(values: &[f32]) -> Vec<f64> {
    values.iter().map(|value| f64::from(*value)).collect()
}

#[derive(Clone, Debug)]
struct Motions(Arc<MotionTree>);

impl HostOperation for Motions {
    /// The outputs.
    type Saved = [HostTensor; 2];

    fn forward(&self, inputs: &[HostTensor], tracked: bool) -> (HostTensor, Option<Self::Saved>) {
        let (of_clusters, of_nodes) = self.0.lengths();
        let [clusters, nodes] = [&inputs[0], &inputs[1]];
        let shape = nodes.shape();
        assert_eq!(clusters.values().len(), shape[0] * of_clusters, "outputs of clusters");
        assert_eq!(nodes.values().len(), shape[0] * of_nodes, "outputs of nodes");
        let mut displacement = vec![0.0; nodes.values().len()];
        let outputs = clusters
            .values()
            .par_chunks(of_clusters.max(1))
            .zip(nodes.values().par_chunks(of_nodes.max(1)));
        displacement.par_chunks_mut(of_nodes.max(1)).zip(outputs).for_each(|(to, (c, n))| {
            write(&self.0.moved(&widen(c), &widen(n)), to);
        });
        let saved = tracked.then(|| [clusters.clone(), nodes.clone()]);
        (HostTensor::new(displacement, shape), saved)
    }

    fn backward(
        &self,
        [clusters, nodes]: Self::Saved,
        cotangent: &[f32],
        _needed: &[bool],
    ) -> Vec<Option<Vec<f32>>> {
        let (of_clusters, of_nodes) = self.0.lengths();
        let (of_clusters, of_nodes) = (of_clusters.max(1), of_nodes.max(1));
        let mut to_clusters = vec![0.0; clusters.values().len()];
        let mut to_nodes = vec![0.0; nodes.values().len()];
        let gradients =
            to_clusters.par_chunks_mut(of_clusters).zip(to_nodes.par_chunks_mut(of_nodes));
        let outputs = clusters
            .values()
            .par_chunks(of_clusters)
            .zip(nodes.values().par_chunks(of_nodes))
            .zip(cotangent.par_chunks(of_nodes));
        gradients.zip(outputs).for_each(|((to_c, to_n), ((c, n), cotangent))| {
            let (mut of_c, mut of_n) = (vec![0.0; c.len()], vec![0.0; n.len()]);
            let at = (&widen(c)[..], &widen(n)[..]);
            self.0.pull_back(at, &widen(cotangent), (&mut of_c, &mut of_n));
            write(&of_c, to_c);
            write(&of_n, to_n);
        });
        vec![Some(to_clusters), Some(to_nodes)]
    }
}

#[cfg(test)]
#[path = "motions/tests.rs"]
mod tests;
