//! Whether the conditions of faces agree where these meet.

use super::agreement::{conflict, differ, magnitude};
use super::lift::{along, edge_lifts};
use crate::domain::Domain;
use crate::error::GpError;
use crate::problem::Problem;
use crate::series::Series;
use crate::structure::{AxisStructure, Lift};

/// Fractions along the remaining axes where corners are compared.
const CORNER_SAMPLES: [f64; 5] = [0.5, 0.11, 0.83, 0.0, 1.0];

/// Compares all faces two by two.
pub(super) fn check_corners<const D: usize>(
    problem: &Problem<D>,
    structures: &[AxisStructure<D>; D],
) -> Result<(), GpError> {
    let varying: Vec<usize> =
        (0..D).filter(|axis| structures[*axis].varies(problem.domain())).collect();
    if let [first, second, ..] = varying[..] {
        let names = problem.domain().names();
        return Err(GpError::Problem(format!(
            "factors of Robin conditions vary on faces of both {} and {}; impose those of one axis at points by `Data::imposed`",
            names[first], names[second]
        )));
    }
    for first in 0..D {
        for second in first + 1..D {
            for a in &structures[first].lifts {
                for b in &structures[second].lifts {
                    check_corner(problem.domain(), a, b)?;
                }
            }
        }
    }
    let mut beyond = structures.iter().skip(2).flat_map(|structure| &structure.lifts);
    beyond.try_for_each(|lift| check_edges(problem, lift))
}

/// A factor that varies along an edge where a slope of the product is held.
fn varies(face: &str, along: &str) -> GpError {
    GpError::Problem(format!(
        "the factor of the Robin condition on {face} varies where it meets {along}, on which a slope is held; give a factor without slope there, or impose one of the two at points by `Data::imposed`"
    ))
}

/// The condition of a face against those on the edges of its polygon.
fn check_edges<const D: usize>(problem: &Problem<D>, lift: &Lift<D>) -> Result<(), GpError> {
    let domain = problem.domain();
    let Some(polygon) = domain.cross_section() else { return Ok(()) };
    for edge in 0..polygon.corners().len() {
        for fraction in [0.0, 0.29, 0.71] {
            let mut point: [f64; D] =
                std::array::from_fn(|d| 0.5 * (domain.lower()[d] + domain.upper()[d]));
            (point[0], point[1]) = polygon.on_edge(edge, fraction).into();
            point[lift.axis] = lift.end();
            let x = Series::plain(point);
            for own in edge_lifts(problem, edge) {
                if let Some(value) = lift.value_factor()
                    && own.slope != 0.0
                    && along(value, own.outwards(), &x).value().abs() > 1e-10
                {
                    return Err(varies(&lift.face(domain), &format!("edge {edge}")));
                }
                let data = &own.data;
                let implied = lift.apply(data, &x).value();
                let asked = own.apply(&lift.data, &x).value();
                let size = magnitude(data, domain) + magnitude(&lift.data, domain);
                if differ(implied, asked, size) {
                    let face = lift.face(domain);
                    let corner = format!("{face}, polygon edge at ({}, {})", point[0], point[1]);
                    return Err(conflict(&corner, implied, asked));
                }
            }
        }
    }
    Ok(())
}

/// Whether the functional of one face, applied to the data of the other, gives what the other's
/// functional makes of the first's data.
fn check_corner<const D: usize>(
    domain: &Domain<D>,
    a: &Lift<D>,
    b: &Lift<D>,
) -> Result<(), GpError> {
    for fraction in CORNER_SAMPLES {
        let mut point: [f64; D] =
            std::array::from_fn(|d| domain.lower()[d] + fraction * domain.extents()[d]);
        (point[a.axis], point[b.axis]) = (a.end(), b.end());
        let x = Series::plain(point);
        for (own, other) in [(a, b), (b, a)] {
            if own.value_factor().is_some_and(|value| !other.lets_pass(value, &x)) {
                return Err(varies(&own.face(domain), &other.face(domain)));
            }
        }
        // ∂ along the second axis of the first face's data, against ∂ along the first of the second's.
        let (implied, asked) = (b.apply(&a.data, &x).value(), a.apply(&b.data, &x).value());
        let size = magnitude(&a.data, domain) + magnitude(&b.data, domain);
        if differ(implied, asked, size) {
            let corner = format!("{}, {}", a.face(domain), b.face(domain));
            return Err(conflict(&corner, implied, asked));
        }
    }
    Ok(())
}
