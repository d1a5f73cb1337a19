//! Quantities of a displacement that samplers read, with their derivatives.

use crate::output::{mean_and_largest, motion_heads, volume_heads};
use sinew_emulate::parts::norm;
use sinew_energy::Body;

/// Volumes of the cavities, then mean and largest nodal displacement.
pub(super) struct Quantities<'b>(pub(super) &'b Body);

impl Quantities<'_> {
    pub(super) fn names(&self) -> Vec<String> {
        [volume_heads(self.0), motion_heads(self.0).into()].concat()
    }

    pub(super) fn of(&self, displacement: &[f64]) -> Vec<f64> {
        let mut values = self.0.cavity_volumes(displacement);
        values.extend(mean_and_largest(displacement));
        values
    }

    /// Derivatives in the displacement of each quantity, as long as the displacement. The largest displacement has that of the node
    /// which moves most.
    pub(super) fn gradients(&self, displacement: &[f64]) -> Vec<Vec<f64>> {
        let nodes = displacement.as_chunks::<3>().0;
        let lengths: Vec<f64> = nodes.iter().map(|u| norm(u)).collect();
        let most = (0..nodes.len()).max_by(|&a, &b| lengths[a].total_cmp(&lengths[b]));
        // A node that does not move has no direction.
        let along = |node: usize, share: f64| {
            let moves = lengths[node] > 0.0;
            nodes[node].map(|u| if moves { share * u / lengths[node] } else { 0.0 })
        };
        let mean = (0..nodes.len()).flat_map(|node| along(node, 1.0 / nodes.len() as f64));
        let of_most = |node| f64::from(u8::from(Some(node) == most));
        let largest = (0..nodes.len()).flat_map(|node| along(node, of_most(node)));
        let mut gradients = self.0.cavity_volume_gradients(displacement);
        gradients.extend([mean.collect(), largest.collect()]);
        gradients
    }

    /// Derivative in the displacement of the quantities' sum with the weights `sens`.
    pub(super) fn slope(&self, displacement: &[f64], sens: &[f64]) -> Vec<f64> {
        let mut slope = vec![0.0; displacement.len()];
        for (gradient, weight) in self.gradients(displacement).iter().zip(sens) {
            slope.iter_mut().zip(gradient).for_each(|(slope, of)| *slope += weight * of);
        }
        slope
    }
}
