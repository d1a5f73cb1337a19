//! Whether the conditions of faces agree where these meet.

use crate::prior::structure::{AxisStructure, Lift};
use crate::problem::domain::grid;
use crate::{Domain, Field, GpError, Problem, Result, Series};

/// Relative difference above which two conditions conflict at a corner: data are given as formulas
/// that agree to rounding where they agree at all.
const CORNER_TOLERANCE: f64 = 1e-8;

/// Compares all faces two by two.
pub(super) fn check_corners<const D: usize>(
    problem: &Problem<D>,
    structures: &[AxisStructure<D>; D],
) -> Result<()> {
    let varying: Vec<usize> =
        (0..D).filter(|axis| structures[*axis].varies(problem.domain())).collect();
    if let [first, second, ..] = varying[..] {
        let names = problem.domain().names();
        return Err(GpError::Invalid(format!(
            "factors of Robin conditions vary on faces of both {} and {}; impose those of one axis at points by `Data::imposed`",
            names[first], names[second]
        )));
    }
    for (number, structure) in structures.iter().enumerate() {
        for a in &structure.lifts {
            for b in structures[number + 1..].iter().flat_map(|other| &other.lifts) {
                check_corner(problem.domain(), a, b)?;
            }
        }
    }
    Ok(())
}

/// Whether the functional of one face, applied to the data of the other, gives what the other's
/// functional makes of the first's data.
fn check_corner<const D: usize>(domain: &Domain<D>, a: &Lift<D>, b: &Lift<D>) -> Result<()> {
    for mut point in diagonal(domain) {
        (point[a.axis], point[b.axis]) = (a.end(), b.end());
        let x = Series::plain(point);
        for (own, other) in [(a, b), (b, a)] {
            ensure!(
                other.lets_pass(&own.value, &x),
                "the factor of the Robin condition on {} varies where it meets {}, on which a slope is held; give a factor without slope there, or impose one of the two at points by `Data::imposed`",
                own.face(domain),
                other.face(domain)
            );
        }
        // ∂ along the second axis of the first face's data, against ∂ along the first of the second's.
        let [implied, asked] = [b.apply(&a.data, &x), a.apply(&b.data, &x)];
        let corner = || format!("{}, {}", a.face(domain), b.face(domain));
        let size = magnitude(&a.data, domain) + magnitude(&b.data, domain);
        agree(corner, [implied.value(), asked.value()], size)?;
    }
    Ok(())
}

/// Refuses a value that the condition of one face implies at a corner if the other face requires another one; rounding is relative
/// to `size`.
fn agree(corner: impl FnOnce() -> String, [implied, asked]: [f64; 2], size: f64) -> Result<()> {
    let scale = (implied.abs() + asked.abs() + size).max(f64::MIN_POSITIVE);
    // NaN differs from everything.
    ensure!(
        (implied - asked).abs() <= CORNER_TOLERANCE * scale || implied == asked,
        "conditions conflict at the corner {}: {implied} from one face, {asked} from the other",
        corner()
    );
    Ok(())
}

/// Places along the diagonal of the domain, whose coordinates beside those of a corner are compared at.
fn diagonal<const D: usize>(domain: &Domain<D>) -> impl Iterator<Item = [f64; D]> {
    [0.5, 0.11, 0.83, 0.0, 1.0]
        .into_iter()
        .map(|fraction| std::array::from_fn(|d| domain.lower()[d] + fraction * domain.extents()[d]))
}

/// Largest value found on a coarse grid: what rounding at a corner is relative to.
fn magnitude<const D: usize>(data: &Field<D>, domain: &Domain<D>) -> f64 {
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
