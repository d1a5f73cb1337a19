//! A volume response that grows without bound as the volume vanishes.

use crate::VolumeEnergy;
use sinew_num::Scalar;

/// `κ(J² − 1 − 2 ln J)`: infinite at J = 0 as at J = ∞, with the bulk modulus 4κ at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compressible {
    /// κ \[stress\].
    pub kappa: f64,
}

impl VolumeEnergy for Compressible {
    fn constants(&self) -> Vec<(&'static str, f64)> {
        vec![("kappa", self.kappa)]
    }

    fn with_softer_volume(&self, factor: f64) -> Option<Self> {
        Some(Self { kappa: factor * self.kappa })
    }

    #[inline]
    fn density<S: Scalar>(&self, volume_change: S) -> S {
        // J² − 1 = (J − 1)(J + 1).
        let squared = volume_change.clone() * (volume_change.clone() + 2.0);
        (squared - volume_change.ln_1p() * 2.0) * self.kappa
    }
}
