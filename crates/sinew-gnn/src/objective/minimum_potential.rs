//! Physics-informed training.

use super::Objective;
use crate::{DataSet, Error, Result, Sample};
use burn::tensor::Tensor;
use sinew_emulate::coordinates::{require_count, require_positive};
use sinew_energy::Body;
use std::sync::Arc;

/// A total potential energy Π(u; θ) of any dimension and material.
pub trait Potential: Send + Sync {
    /// Length of a displacement.
    fn degrees_of_freedom(&self) -> usize;

    /// Why the potential cannot be evaluated at θ, if so; asked once per sample before training.
    fn objection(&self, theta: &[f64]) -> Option<String> {
        let _ = theta;
        None
    }

    /// Whether a body can have this displacement: no cell is inverted, and no barrier bounds its energy.
    fn admits(&self, displacement: &[f64], theta: &[f64]) -> bool {
        let _ = (displacement, theta);
        true
    }

    /// Π(u; θ), and ∂Π/∂u written over `gradient`. Displacements are flattened node by node.
    fn value_and_gradient(&self, displacement: &[f64], theta: &[f64], gradient: &mut [f64]) -> f64;
}

/// Mean total potential energy of the predictions (thesis, Equations 3.12 and 3.16) in units of a
/// characteristic energy: no simulation enters.
#[doc(alias("PINN", "deep energy method", "physics-informed"))]
#[derive(Clone)]
pub struct MinimumPotential {
    potentials: Vec<Arc<dyn Potential>>,
    energy: f64,
}

impl MinimumPotential {
    /// Objective with one potential per geometry. `energy` makes the loss dimensionless; an estimate of the
    /// typical |Π| does, for instance by [`MinimumPotential::energy_of_linear_response`].
    ///
    /// # Errors
    /// An energy that is not positive.
    pub fn new(potentials: Vec<Arc<dyn Potential>>, energy: f64) -> Result<Self> {
        require_positive("the characteristic energy", energy)?;
        Ok(Self { potentials, energy })
    }

    /// Strain energy of a small multiple of `displacement`, scaled back as if the body were
    /// linear: `½ uᵀ K u` with the stiffness K at rest.
    ///
    /// # Errors
    /// A displacement of the wrong length, or a potential that is not finite near rest.
    pub fn energy_of_linear_response(
        potential: &dyn Potential,
        displacement: &[f64],
        theta: &[f64],
    ) -> Result<f64> {
        /// Relative to the displacement: small enough for linearity, large beside rounding.
        const STEP: f64 = 1e-6;
        let length = potential.degrees_of_freedom();
        require_count("displacement values", displacement.len(), length)?;
        let (mut at_rest, mut near_rest) = (vec![0.0; length], vec![0.0; length]);
        let small: Vec<f64> = displacement.iter().map(|value| STEP * value).collect();
        potential.value_and_gradient(&vec![0.0; length], theta, &mut at_rest);
        potential.value_and_gradient(&small, theta, &mut near_rest);
        let forces = near_rest.iter().zip(&at_rest).map(|(near, rest)| (near - rest) / STEP);
        let energy =
            0.5 * forces.zip(displacement).map(|(force, value)| force * value).sum::<f64>();
        require_positive("the energy of the linear response", energy)?;
        Ok(energy)
    }
}

impl Objective for MinimumPotential {
    fn check(&self, data: &DataSet) -> Result<()> {
        require_count("potentials", self.potentials.len(), data.geometries.len())?;
        self.potentials.iter().zip(&data.geometries).try_for_each(|(potential, geometry)| {
            let (found, expected) =
                (potential.degrees_of_freedom(), geometry.dirichlet.prescribed.len());
            require_count("degrees of freedom of a potential", found, expected)
        })?;
        let samples = data.training.iter().chain(&data.validation).enumerate();
        for (sample, Sample { geometry, theta, .. }) in samples {
            let potential = self.potentials.get(*geometry);
            if let Some(reason) = potential.and_then(|potential| potential.objection(theta)) {
                return Err(Error::Parameters { sample, reason });
            }
        }
        Ok(())
    }

    fn loss(&self, samples: &[&Sample], displacement: Tensor<3>) -> Result<Tensor<1>> {
        let potential = self.potentials[samples[0].geometry].clone();
        let thetas: Vec<_> = samples.iter().map(|sample| sample.theta.clone()).collect();
        let energies = crate::fused::fused_potential(displacement, move |u, sample, gradient| {
            potential.value_and_gradient(u, &thetas[sample], gradient)
        });
        Ok((energies / self.energy).mean())
    }

    fn inadmissible(&self, samples: &[&Sample], displacement: Tensor<3>) -> usize {
        let potential = &self.potentials[samples[0].geometry];
        let values: Vec<f64> = displacement.into_data().iter::<f64>().collect();
        let fields = values.chunks_exact(potential.degrees_of_freedom().max(1));
        let cases = fields.zip(samples);
        cases.filter(|(field, sample)| !potential.admits(field, &sample.theta)).count()
    }
}

impl Potential for Body {
    fn degrees_of_freedom(&self) -> usize {
        3 * self.nodes
    }

    fn objection(&self, theta: &[f64]) -> Option<String> {
        if !self.has_potential() {
            return Some("mixed elements and pressures with a loose rim have no potential; close the rim by a lid (`rim = \"closed\"` in a case file), or choose other elements".into());
        }
        self.check_theta(theta).err().map(|error| error.to_string())
    }

    fn admits(&self, displacement: &[f64], theta: &[f64]) -> bool {
        self.is_within_barriers(displacement, theta)
    }

    fn value_and_gradient(&self, displacement: &[f64], theta: &[f64], gradient: &mut [f64]) -> f64 {
        self.value_and_gradient(displacement, theta, gradient)
    }
}
