//! Whether conditions agree where they meet.

use crate::error::{GpError, Result};
use crate::problem::domain::Domain;
use crate::problem::field::Field;
use crate::problem::grid::grid;

/// Relative difference above which two conditions conflict at a corner: data are given as formulas
/// that agree to rounding where they agree at all.
const CORNER_TOLERANCE: f64 = 1e-8;

/// Refuses a value that the condition of one face implies at a corner if the other face requires another one; rounding is relative
/// to `size`.
pub(super) fn agree(
    corner: impl FnOnce() -> String,
    [implied, asked]: [f64; 2],
    size: f64,
) -> Result<()> {
    let scale = (implied.abs() + asked.abs() + size).max(f64::MIN_POSITIVE);
    // NaN differs from everything.
    if (implied - asked).abs() <= CORNER_TOLERANCE * scale || implied == asked {
        return Ok(());
    }
    Err(GpError::Invalid(format!(
        "conditions conflict at the corner {}: {implied} from one face, {asked} from the other",
        corner()
    )))
}

/// Places along the diagonal of the domain, whose coordinates beside those of a corner are compared at.
pub(super) fn diagonal<const D: usize>(domain: &Domain<D>) -> impl Iterator<Item = [f64; D]> {
    [0.5, 0.11, 0.83, 0.0, 1.0]
        .into_iter()
        .map(|fraction| std::array::from_fn(|d| domain.lower()[d] + fraction * domain.extents()[d]))
}

/// Largest value found on a coarse grid: what rounding at a corner is relative to.
pub(super) fn magnitude<const D: usize>(data: &Field<D>, domain: &Domain<D>) -> f64 {
    if data.is_zero() {
        return 0.0;
    }
    let along = |d: usize| {
        // Off the middle, where sines vanish.
        let places = [0.0, 0.37, 0.71, 1.0].iter();
        places.map(|fraction| domain.lower()[d] + fraction * domain.extents()[d]).collect()
    };
    let points = grid(&std::array::from_fn(along)).into_iter();
    points.map(|point| data.value(point).abs()).fold(0.0, f64::max)
}
