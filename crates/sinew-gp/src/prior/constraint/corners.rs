//! Whether the conditions of faces agree where these meet.

use crate::prior::structure::{AxisStructure, Lift};
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
/// functional makes of the first's data; at places along the diagonal of the domain.
fn check_corner<const D: usize>(domain: &Domain<D>, a: &Lift<D>, b: &Lift<D>) -> Result<()> {
    let size = magnitude(&a.data, domain)? + magnitude(&b.data, domain)?;
    for share in [0.5, 0.11, 0.83, 0.0, 1.0] {
        let mut point: [f64; D] = domain.ends.map(|[lower, upper]| lower + share * (upper - lower));
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
        let [implied, asked] =
            [b.apply(&a.data, &x), a.apply(&b.data, &x)].map(|given| given.value());
        let scale = (implied.abs() + asked.abs() + size).max(f64::MIN_POSITIVE);
        // NaN differs from everything.
        ensure!(
            (implied - asked).abs() <= CORNER_TOLERANCE * scale || implied == asked,
            "conditions conflict at the corner {}, {}: {implied} from one face, {asked} from the other",
            a.face(domain),
            b.face(domain)
        );
    }
    Ok(())
}

/// Largest value found: what rounding at a corner is relative to.
fn magnitude<const D: usize>(data: &Field<D>, domain: &Domain<D>) -> Result<f64> {
    const PLACES: usize = 64;
    let places = domain.sample(PLACES, 0)?.into_iter();
    Ok(places.map(|x| data.value(x).abs()).fold(0.0, f64::max))
}
