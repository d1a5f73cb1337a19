//! Thick incompressible sphere under internal follower pressure.

use super::{NoSignChange, root};

/// A sphere of incompressible neo-Hookean rubber, `Ψ = ½μ(I₁ − 3)`, with pressure inside: the closed form of
/// A. E. Green and J. E. Adkins, "Large elastic deformations", 1960.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThickSphere {
    /// Shear modulus μ \[stress\].
    pub shear: f64,
    /// Inner radius at rest \[length\].
    pub inner: f64,
    /// Outer radius at rest \[length\].
    pub outer: f64,
}

/// The largest pressure that a sphere bears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitPoint {
    /// Inner radius over the one at rest.
    pub stretch: f64,
    /// Pressure \[stress\].
    pub pressure: f64,
}

impl ThickSphere {
    /// Deformed outer radius \[length\] when the inner one is `a` \[length\].
    pub fn outer_radius(&self, a: f64) -> f64 {
        (self.outer.powi(3) + a.powi(3) - self.inner.powi(3)).cbrt()
    }

    /// Pressure that blows the inner radius up to `a` \[length\]:
    /// `p = μ[2/λ_b + 1/(2λ_b⁴) − 2/λ_a − 1/(2λ_a⁴)]` with the hoop stretches at both surfaces.
    pub fn pressure(&self, a: f64) -> f64 {
        let term = |stretch: f64| 2.0 / stretch + 0.5 / stretch.powi(4);
        let (inside, outside) = (a / self.inner, self.outer_radius(a) / self.outer);
        self.shear * (term(outside) - term(inside))
    }

    /// Stretch at which the pressure is largest.
    ///
    /// # Errors
    /// [`NoSignChange`] when the maximum is not below a stretch of 100.
    pub fn limit_point(&self) -> Result<LimitPoint, NoSignChange> {
        let slope = |stretch: f64| -2.0 / stretch.powi(2) - 2.0 / stretch.powi(5);
        let rise = |a: f64| {
            let b = self.outer_radius(a);
            let outside = (a / b).powi(2) / self.outer * slope(b / self.outer);
            outside - slope(a / self.inner) / self.inner
        };
        let a = root(rise, [1.0001 * self.inner, 100.0 * self.inner])?;
        Ok(LimitPoint { stretch: a / self.inner, pressure: self.pressure(a) })
    }
}
