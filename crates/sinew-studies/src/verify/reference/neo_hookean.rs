//! Homogeneous states of the compressible neo-Hookean solid of thesis eq. (3.1) with μ = 1.

use super::root;
use anyhow::Result;

/// Stretch across the load and first Piola–Kirchhoff stress along it \[μ\] of a block that is stretched alike along one axis or
/// two, its other faces free.
///
/// # Errors
/// Stretches or parameters that are not positive.
pub fn neo_hookean_block(lame: f64, axes: usize, stretch: f64) -> Result<[f64; 2]> {
    let log_volume = |across: f64| (stretch.powi(axes as i32) * across.powi(3 - axes as i32)).ln();
    // Along a principal axis `μ(s − 1/s) + λ ln J / s`.
    let stress =
        |stretch: f64, across: f64| stretch - 1.0 / stretch + lame * log_volume(across) / stretch;
    let across = root(|across| stress(across, across), [1e-3, 1e3])?;
    Ok([across, stress(stretch, across)])
}
