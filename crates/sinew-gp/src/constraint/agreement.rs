//! Whether conditions agree where they meet.

use crate::domain::Domain;
use crate::error::GpError;
use crate::field::Field;

/// Relative difference above which two conditions conflict at a corner: data are given as formulas
/// that agree to rounding where they agree at all.
const CORNER_TOLERANCE: f64 = 1e-8;

/// Value that the condition of one face implies at a corner, and the one that the other face requires.
pub(super) fn conflict(corner: &str, implied: f64, asked: f64) -> GpError {
    GpError::Problem(format!(
        "conditions conflict at the corner {corner}: {implied} from one face, {asked} from the other"
    ))
}

/// Largest value found on a coarse grid: what rounding at a corner is relative to.
pub(super) fn magnitude<const D: usize>(data: &Field<D>, domain: &Domain<D>) -> f64 {
    if data.is_zero() {
        return 0.0;
    }
    // Off the middle, where sines vanish.
    const FRACTIONS: [f64; 4] = [0.0, 0.37, 0.71, 1.0];
    (0..4_usize.pow(D as u32))
        .map(|number| {
            let fraction = |d: usize| FRACTIONS[number / 4_usize.pow(d as u32) % 4];
            let point =
                std::array::from_fn(|d| domain.lower()[d] + fraction(d) * domain.extents()[d]);
            data.value(point).abs()
        })
        .fold(0.0, f64::max)
}

pub(super) fn differ(a: f64, b: f64, scale: f64) -> bool {
    // NaN differs from everything.
    let close =
        (a - b).abs() <= CORNER_TOLERANCE * (a.abs() + b.abs() + scale).max(f64::MIN_POSITIVE);
    !(close || a == b)
}
