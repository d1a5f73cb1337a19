//! Data-driven training in the energy norm of the body's stiffness.

use std::sync::Arc;

use burn::tensor::Tensor;
use sinew_energy::Stiffness;

use super::{Batch, Objective, SQUARED_NORM_FLOOR, require_displacements};
use crate::data::DataSet;
use crate::error::Result;
use sinew_emulate::coordinates::{require_count, require_positive};

/// Energy norm of the error `√((u − û)ᵀ K (u − û))`, relative to the standard deviation of the simulations in the same
/// norm. [`DataFit`](super::DataFit) weighs all motions equally, so a network learns the stiff ones last, although these
/// carry the strains.
#[derive(Debug, Clone)]
pub struct EnergyNormFit {
    stiffnesses: Vec<Arc<Stiffness>>,
    energy_root: f64,
}

/// Simulations over which the standard deviation is taken. It only sets the unit of the loss.
const SIMULATIONS_OF_SPREAD: usize = 32;

impl EnergyNormFit {
    /// Objective with a frozen stiffness per geometry. `data` sets the unit of the loss: the root mean square of `√(eᵀ K e)` with the
    /// departures e of its simulations from their mean.
    ///
    /// # Errors
    /// A stiffness that fits no geometry, simulations that are missing or all the same.
    pub fn new(stiffnesses: Vec<Stiffness>, data: &DataSet) -> Result<Self> {
        require_count("stiffnesses", stiffnesses.len(), data.geometries.len())?;
        require_displacements(data)?;
        let (mut sum, mut count) = (0.0, 0);
        for (geometry, stiffness) in stiffnesses.iter().enumerate() {
            let size = 3 * stiffness.nodes();
            let expected = 3 * data.geometries[geometry].topology.real_nodes;
            require_count("unknowns of a stiffness", size, expected)?;
            let samples = data.training.iter().filter(|sample| sample.geometry == geometry);
            let fields: Vec<&[f64]> = samples
                .map(|sample| &sample.displacement[..])
                .take(SIMULATIONS_OF_SPREAD)
                .collect();
            let mean: Vec<f64> = (0..size)
                .map(|i| fields.iter().map(|field| field[i]).sum::<f64>() / fields.len() as f64)
                .collect();
            sum += fields.iter().map(|field| squared_norm(stiffness, field, &mean).0).sum::<f64>();
            count += fields.len();
        }
        let energy_root = (sum / count.max(1) as f64).sqrt();
        require_positive("the spread of the simulations", energy_root)?;
        Ok(Self { stiffnesses: stiffnesses.into_iter().map(Arc::new).collect(), energy_root })
    }
}

/// `eᵀ K e` and `K e` of a difference e of displacements.
fn squared_norm(stiffness: &Stiffness, a: &[f64], b: &[f64]) -> (f64, Vec<f64>) {
    let error: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    let mut forces = vec![0.0; error.len()];
    stiffness.apply(&error, &mut forces);
    (forces.iter().zip(&error).map(|(f, e)| f * e).sum(), forces)
}

impl Objective for EnergyNormFit {
    fn check(&self, data: &DataSet) -> Result<()> {
        require_count("stiffnesses", self.stiffnesses.len(), data.geometries.len())?;
        let pairs = self.stiffnesses.iter().zip(&data.geometries);
        for (stiffness, geometry) in pairs {
            require_count("nodes of a stiffness", stiffness.nodes(), geometry.topology.real_nodes)?;
        }
        require_displacements(data)
    }

    fn loss(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> Result<Tensor<1>> {
        let stiffness = self.stiffnesses[batch.geometry].clone();
        let simulated = batch.samples.iter().map(|sample| sample.displacement.clone());
        let (simulated, unit) =
            (simulated.collect::<Vec<_>>(), self.energy_root * self.energy_root);
        let norm = move |displacement: &[f64], sample: usize, gradient: &mut [f64]| {
            let (square, forces) = squared_norm(&stiffness, displacement, &simulated[sample]);
            // Away from rest a stiffness may have a negative eigenvalue.
            let norm = (square.max(0.0) / unit + SQUARED_NORM_FLOOR).sqrt();
            gradient.iter_mut().zip(forces).for_each(|(g, force)| *g = force / (unit * norm));
            norm
        };
        Ok(crate::fused::fused_potential(displacement, norm).mean())
    }
}
