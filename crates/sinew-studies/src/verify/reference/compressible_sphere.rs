//! Thick compressible sphere under internal follower pressure.

use super::{NoSignChange, integrate, root};

/// Tolerance of the integration, far below that of any mesh.
const TOLERANCE: f64 = 1e-12;

/// A sphere of the compressible neo-Hookean solid of thesis eq. (3.1) with pressure inside: a boundary value
/// problem of radial equilibrium, `dP_r/dR + 2(P_r − P_t)/R = 0`, solved by shooting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompressibleSphere {
    /// μ \[stress\].
    pub shear: f64,
    /// λ \[stress\].
    pub lame: f64,
    /// Inner radius at rest \[length\].
    pub inner: f64,
    /// Outer radius at rest \[length\].
    pub outer: f64,
}

/// Outward displacements of the surfaces of a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inflation {
    /// Radial displacement of the inner surface \[length\].
    pub inner: f64,
    /// Radial displacement of the outer surface \[length\].
    pub outer: f64,
}

impl CompressibleSphere {
    /// The equilibrium under a pressure \[stress\] that inflates the inner radius by less than a half.
    ///
    /// # Errors
    /// [`NoSignChange`] without a sign change.
    pub fn inflate(&self, pressure: f64) -> Result<Inflation, NoSignChange> {
        let unloaded = |inner: f64| {
            // No solution: the wall is pushed apart further than it can bear.
            self.shoot(inner, pressure).map_or(f64::NEG_INFINITY, |[_, stress]| stress)
        };
        // Below the equilibrium the outer surface is pulled, beyond it pushed.
        let found = root(unloaded, [self.inner, 1.5 * self.inner])?;
        let [outer, _] = self.shoot(found, pressure).unwrap_or([f64::NAN; 2]);
        Ok(Inflation { inner: found - self.inner, outer: outer - self.outer })
    }

    /// Deformed outer radius and radial Piola stress there when the inner radius is `inner`.
    fn shoot(&self, inner: f64, pressure: f64) -> Option<[f64; 2]> {
        let stress = -pressure * (inner / self.inner).powi(2);
        let span = [self.inner, self.outer];
        integrate(|radius, state| self.slope(radius, state), span, [inner, stress], TOLERANCE)
    }

    /// `[dr/dR, dP_r/dR]`.
    fn slope(&self, radius: f64, &[place, stress]: &[f64; 2]) -> [f64; 2] {
        let hoop = place / radius;
        let Some(radial) = self.radial_stretch(hoop, stress) else { return [f64::NAN; 2] };
        let (log_volume, shear) = ((radial * hoop * hoop).ln(), self.shear);
        let hoop_stress = (self.lame * log_volume - shear) / hoop + shear * hoop;
        [radial, -2.0 * (stress - hoop_stress) / radius]
    }

    /// Radial stretch λ_r at which `P_r = (λ ln J − μ)/λ_r + μλ_r` has the given value.
    fn radial_stretch(&self, hoop: f64, stress: f64) -> Option<f64> {
        let mut radial = hoop.powi(-2);
        for _ in 0..100 {
            let log_volume = (radial * hoop * hoop).ln();
            let excess = self.lame * log_volume - self.shear;
            let gap = excess / radial + self.shear * radial - stress;
            let rise = (self.lame - excess) / (radial * radial) + self.shear;
            let step = gap / rise;
            radial = (radial - step).max(0.5 * radial);
            if step.abs() <= 1e-15 * radial {
                return Some(radial);
            }
            if !radial.is_finite() {
                return None;
            }
        }
        // Newton's method ends in a cycle of the last bits.
        Some(radial)
    }
}
