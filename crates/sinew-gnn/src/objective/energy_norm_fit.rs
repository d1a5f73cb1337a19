//! Data-driven training that weighs errors as the body's stiffness does.

use burn::tensor::{Tensor, TensorData};

use super::{Batch, Objective, SQUARED_NORM_FLOOR, require_displacements, simulated};
use crate::data::DataSet;
use crate::error::{Error, Result, require_count, require_finite, require_positive};

/// Mean nodal length of `K^½ (u − û)`, in units of the simulations' own spread: the root of the energy that
/// an error costs, where the plain [`DataFit`](super::DataFit) weighs all motions alike and so leaves the stiff
/// ones, which make the strains, for last.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyNormFit {
    roots: Vec<Root>,
    energy_root: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct Root {
    size: usize,
    entries: Vec<f32>,
}

/// Simulations that the spread is measured over: it only sets the unit of the loss.
const SIMULATIONS_OF_SPREAD: usize = 32;

impl EnergyNormFit {
    /// With one root `K^½` per geometry: a symmetric matrix over all degrees of freedom, row by row, zero where
    /// displacements are prescribed [√energy per length]. `data` sets the unit of the loss: the root mean square of
    /// `K^½ (u − ū)` over its simulations.
    ///
    /// # Errors
    /// A root that fits no geometry or is not finite, simulations that are missing or all the same.
    pub fn new(roots: &[Vec<f64>], data: &DataSet) -> Result<Self> {
        require_count("roots of a stiffness", roots.len(), data.geometries.len())?;
        let mut sum = 0.0;
        let mut count = 0;
        for (geometry, root) in roots.iter().enumerate() {
            let size = data.geometries[geometry].dirichlet.prescribed.len();
            require_displacements(data, size)?;
            require_count("entries of the root of a stiffness", root.len(), size * size)?;
            require_finite("the root of a stiffness", root)?;
            let samples = data.training.iter().filter(|sample| sample.geometry == geometry);
            let fields: Vec<&[f64]> = samples
                .map(|sample| &sample.displacement[..])
                .take(SIMULATIONS_OF_SPREAD)
                .collect();
            for field in &fields {
                let departure: Vec<f64> = (0..size)
                    .map(|i| {
                        field[i] - fields.iter().map(|f| f[i]).sum::<f64>() / fields.len() as f64
                    })
                    .collect();
                let dot = |row: &[f64]| row.iter().zip(&departure).map(|(a, b)| a * b).sum::<f64>();
                sum += root.chunks_exact(size.max(1)).map(|row| dot(row).powi(2)).sum::<f64>();
                count += size;
            }
        }
        let energy_root = (sum / count.max(1) as f64).sqrt();
        require_positive("the spread of the simulations", energy_root)?;
        let roots = roots
            .iter()
            .zip(&data.geometries)
            .map(|(root, geometry)| Root {
                size: geometry.dirichlet.prescribed.len(),
                entries: root.iter().map(|&entry| entry as f32).collect(),
            })
            .collect();
        Ok(Self { roots, energy_root })
    }
}

impl Objective for EnergyNormFit {
    fn check(&self, data: &DataSet) -> Result<()> {
        require_count("roots of a stiffness", self.roots.len(), data.geometries.len())?;
        self.roots.iter().try_for_each(|root| require_displacements(data, root.size))
    }

    fn loss(&self, batch: &Batch<'_>, displacement: Tensor<3>) -> Result<Tensor<1>> {
        let root = self.roots.get(batch.geometry).ok_or(Error::UnknownGeometry {
            sample: 0,
            geometry: batch.geometry,
            geometries: self.roots.len(),
        })?;
        let (dims, device) = (displacement.dims(), displacement.device());
        let error = displacement - simulated(batch, dims, &device);
        let data = TensorData::new(root.entries.clone(), [root.size, root.size]);
        let flat = error.reshape([dims[0], root.size]).matmul(Tensor::from_data(data, &device));
        let weighed = flat.reshape(dims) / self.energy_root;
        Ok(((weighed.clone() * weighed).sum_dim(2) + SQUARED_NORM_FLOOR).sqrt().mean())
    }
}
