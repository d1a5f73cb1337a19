//! Thick incompressible cylinder under internal follower pressure.

/// A long tube of incompressible neo-Hookean rubber in plane strain with pressure inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThickCylinder {
    /// Shear modulus μ \[stress\].
    pub shear: f64,
    /// Inner radius at rest \[length\].
    pub inner: f64,
    /// Outer radius at rest \[length\].
    pub outer: f64,
}

impl ThickCylinder {
    /// Deformed outer radius \[length\] when the inner one is `a` \[length\].
    pub(crate) fn outer_radius(&self, a: f64) -> f64 {
        (self.outer.powi(2) + a.powi(2) - self.inner.powi(2)).sqrt()
    }

    /// Pressure that blows the inner radius up to `a` \[length\]: the integral of the hoop's excess stress
    /// `μ(λ² − λ⁻²)` over the deformed wall, `p = μ[ln(B/A) − ln(b/a) + ½k(a⁻² − b⁻²)]`, `k = a² − A²`.
    pub fn pressure(&self, a: f64) -> f64 {
        let b = self.outer_radius(a);
        let swept = a.powi(2) - self.inner.powi(2);
        let thinning = (self.outer / self.inner).ln() - (b / a).ln();
        self.shear * (thinning + 0.5 * swept * (a.powi(-2) - b.powi(-2)))
    }
}
