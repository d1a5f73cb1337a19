//! Homogeneous states of the compressible neo-Hookean solid of thesis eq. (3.1).

use super::{NoSignChange, root};

/// A stretched bar or sheet with free faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Stretch across the load.
    pub across: f64,
    /// First Piola–Kirchhoff stress along the load \[stress\].
    pub stress: f64,
    /// Energy density \[stress\].
    pub energy: f64,
}

/// A bar stretched along one axis; the other two contract alike.
///
/// # Errors
/// [`NoSignChange`] for stretches or parameters that are not positive.
pub fn uniaxial_bar(shear: f64, lame: f64, stretch: f64) -> Result<Bar, NoSignChange> {
    bar(shear, lame, |across| [stretch, across, across])
}

/// A sheet stretched alike along two axes.
///
/// # Errors
/// [`NoSignChange`] for stretches or parameters that are not positive.
pub fn equibiaxial_bar(shear: f64, lame: f64, stretch: f64) -> Result<Bar, NoSignChange> {
    bar(shear, lame, |across| [stretch, stretch, across])
}

fn bar(shear: f64, lame: f64, stretches: impl Fn(f64) -> [f64; 3]) -> Result<Bar, NoSignChange> {
    let volume = |across: f64| stretches(across).iter().product::<f64>();
    let pull = |across: f64| principal_stress(shear, lame, across, volume(across));
    let across = root(pull, [1e-3, 1e3])?;
    let (stretches, volume) = (stretches(across), volume(across));
    let excess = stretches.iter().map(|s| s * s).sum::<f64>() - 3.0;
    let energy = 0.5 * lame * volume.ln().powi(2) - shear * volume.ln() + 0.5 * shear * excess;
    Ok(Bar { across, stress: principal_stress(shear, lame, stretches[0], volume), energy })
}

/// Piola stress along a principal axis: `μ(s − 1/s) + λ ln J / s`.
fn principal_stress(shear: f64, lame: f64, stretch: f64, volume: f64) -> f64 {
    shear * (stretch - 1.0 / stretch) + lame * volume.ln() / stretch
}
