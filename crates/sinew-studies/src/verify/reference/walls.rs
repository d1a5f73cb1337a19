//! Thick walls under internal follower pressure, and homogeneous states, of shear modulus μ = 1 \[stress\].

use super::{integrate, root};
use anyhow::Result;

/// Inner and outer radius of spheres and cylinders at rest \[length\].
pub const RADII: [f64; 2] = [1.0, 2.0];

/// Deformed outer radius of an incompressible sphere (`dimension` 3) or cylinder (2) when the inner one is `a`.
pub fn outer_radius(dimension: i32, a: f64) -> f64 {
    let [inner, outer] = RADII.map(|radius| radius.powi(dimension));
    let power = outer + a.powi(dimension) - inner;
    if dimension == 2 { power.sqrt() } else { power.cbrt() }
}

/// Pressure that blows the inner radius of an incompressible sphere, `Ψ = ½μ(I₁ − 3)`, up to `a`:
/// `p = μ[2/λ_b + 1/(2λ_b⁴) − 2/λ_a − 1/(2λ_a⁴)]` with the hoop stretches at both surfaces (A. E. Green and J. E. Adkins, "Large
/// elastic deformations", 1960).
pub fn sphere_pressure(a: f64) -> f64 {
    let term = |stretch: f64| 2.0 / stretch + 0.5 / stretch.powi(4);
    term(outer_radius(3, a) / RADII[1]) - term(a / RADII[0])
}

/// Inner radius over the one at rest where the pressure of the sphere is largest, and that pressure.
pub fn sphere_limit_point() -> Result<[f64; 2]> {
    let [inner, outer] = RADII;
    let slope = |stretch: f64| -2.0 / stretch.powi(2) - 2.0 / stretch.powi(5);
    let rise = |a: f64| {
        let b = outer_radius(3, a);
        (a / b).powi(2) / outer * slope(b / outer) - slope(a / inner) / inner
    };
    let a = root(rise, [1.0001 * inner, 100.0 * inner])?;
    Ok([a / inner, sphere_pressure(a)])
}

/// Pressure that blows the inner radius of a long incompressible tube in plane strain up to `a`: the integral of the hoop's excess
/// stress `μ(λ² − λ⁻²)` over the deformed wall, `p = μ[ln(B/A) − ln(b/a) + ½k(a⁻² − b⁻²)]`, `k = a² − A²`.
pub fn tube_pressure(a: f64) -> f64 {
    let ([inner, outer], b) = (RADII, outer_radius(2, a));
    let swept = a.powi(2) - inner.powi(2);
    (outer / inner).ln() - (b / a).ln() + 0.5 * swept * (a.powi(-2) - b.powi(-2))
}

/// Outward displacements of the inner and the outer surface of a sphere of the compressible neo-Hookean solid of thesis eq. (3.1)
/// under a pressure that inflates it by less than a half: radial equilibrium `dP_r/dR + 2(P_r − P_t)/R = 0` by shooting.
pub fn inflated_sphere(lame: f64, pressure: f64) -> Result<[f64; 2]> {
    let [inner, outer] = RADII;
    // Deformed outer radius and radial Piola stress there for a deformed inner radius.
    let shoot = |place: f64| {
        let start = [place, -pressure * (place / inner).powi(2)];
        integrate(|radius, state| radial_slope(lame, radius, state), RADII, start)
    };
    // Below the equilibrium the outer surface is pulled, beyond it pushed; a wall without a solution is pushed apart further than
    // it can bear.
    let unloaded = |place: f64| shoot(place).map_or(f64::NEG_INFINITY, |[_, stress]| stress);
    let found = root(unloaded, [inner, 1.5 * inner])?;
    Ok([found - inner, shoot(found).map_or(f64::NAN, |[place, _]| place) - outer])
}

/// `[dr/dR, dP_r/dR]`.
fn radial_slope(lame: f64, radius: f64, &[place, stress]: &[f64; 2]) -> [f64; 2] {
    let hoop = place / radius;
    let radial = radial_stretch(lame, hoop, stress);
    let hoop_stress = (lame * (radial * hoop * hoop).ln() - 1.0) / hoop + hoop;
    [radial, -2.0 * (stress - hoop_stress) / radius]
}

/// Radial stretch λ_r at which `P_r = (λ ln J − μ)/λ_r + μλ_r` has the given value, by Newton's method.
fn radial_stretch(lame: f64, hoop: f64, stress: f64) -> f64 {
    let mut radial = hoop.powi(-2);
    // At most to the cycle of the last bits.
    for _ in 0..100 {
        let excess = lame * (radial * hoop * hoop).ln() - 1.0;
        let step =
            (excess / radial + radial - stress) / ((lame - excess) / (radial * radial) + 1.0);
        radial = (radial - step).max(0.5 * radial);
        if step.abs() <= 1e-15 * radial {
            break;
        }
    }
    radial
}

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
