//! Quantities of a displacement that samplers read, with their derivatives.

use crate::output::{mean_and_largest, motion_heads, volume_heads};
use sinew_emulate::parts::dot;
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
    fn gradients(&self, displacement: &[f64]) -> Vec<Vec<f64>> {
        let nodes = displacement.as_chunks::<3>().0;
        let length = |u: &[f64; 3]| u.iter().map(|x| x * x).sum::<f64>().sqrt();
        let along = |node: usize, share: f64, slope: &mut [f64]| {
            let size = length(&nodes[node]);
            // A node that does not move has no direction.
            if size > 0.0 {
                (0..3).for_each(|i| slope[3 * node + i] = share * nodes[node][i] / size);
            }
        };
        let (mut mean, mut largest) =
            (vec![0.0; displacement.len()], vec![0.0; displacement.len()]);
        (0..nodes.len()).for_each(|node| along(node, 1.0 / nodes.len() as f64, &mut mean));
        let most =
            (0..nodes.len()).max_by(|&a, &b| length(&nodes[a]).total_cmp(&length(&nodes[b])));
        most.into_iter().for_each(|node| along(node, 1.0, &mut largest));
        let mut gradients = self.0.cavity_volume_gradients(displacement);
        gradients.extend([mean, largest]);
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

    /// Rates of the quantities at a rate of the displacement.
    pub(super) fn rates(&self, displacement: &[f64], rate: &[f64]) -> Vec<f64> {
        self.gradients(displacement).iter().map(|gradient| dot(gradient, rate)).collect()
    }
}
