//! Quadratic penalty on changes of volume.

use crate::VolumeEnergy;
use sinew_num::Scalar;

/// `½P(J − 1)²`, the volume response of thesis eqs. (3.5) and (3.6).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penalty {
    /// P \[stress\].
    pub bulk_modulus: f64,
}

impl VolumeEnergy for Penalty {
    fn constants(&self) -> Vec<(&'static str, f64)> {
        vec![("bulk modulus", self.bulk_modulus)]
    }

    fn with_softer_volume(&self, factor: f64) -> Option<Self> {
        Some(Self { bulk_modulus: factor * self.bulk_modulus })
    }

    #[inline]
    fn density<S: Scalar>(&self, volume_change: S) -> S {
        volume_change.squared() * (0.5 * self.bulk_modulus)
    }
}
