//! Whether the conditions of faces agree where these meet.

use super::edges::Edges;
use super::lift::along;
use crate::domain::Domain;
use crate::error::GpError;
use crate::field::Field;
use crate::problem::Problem;
use crate::series::Series;
use crate::structure::{AxisStructure, Functional, Lift};

/// Relative difference above which two conditions conflict at a corner: data are given as formulas
/// that agree to rounding where they agree at all.
const CORNER_TOLERANCE: f64 = 1e-8;

/// Fractions along the remaining axes where corners are compared.
const CORNER_SAMPLES: [f64; 5] = [0.5, 0.11, 0.83, 0.0, 1.0];

/// Compares all faces two by two.
pub(super) fn check_corners<const D: usize>(
    problem: &Problem<D>,
    structures: &[AxisStructure<D>; D],
    edges: &Edges<D>,
) -> Result<(), GpError> {
    let varying: Vec<usize> =
        (0..D).filter(|axis| structures[*axis].varies(problem.domain(), *axis)).collect();
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
                    check_corner(problem, (first, a), (second, b))?;
                }
            }
        }
    }
    for axis in 2..D {
        for lift in &structures[axis].lifts {
            check_edges(problem, (axis, lift), edges)?;
        }
    }
    edges.check_corners(problem.domain())
}

/// A factor that varies along an edge where a slope of the product is held.
fn varies(face: &str, along: &str) -> GpError {
    GpError::Problem(format!(
        "the factor of the Robin condition on {face} varies where it meets {along}, on which a slope is held; give a factor without slope there, or impose one of the two at points by `Data::imposed`"
    ))
}

/// The condition of a face against those on the edges of its polygon.
fn check_edges<const D: usize>(
    problem: &Problem<D>,
    (axis, lift): (usize, &Lift<D>),
    edges: &Edges<D>,
) -> Result<(), GpError> {
    let domain = problem.domain();
    let Some(polygon) = domain.cross_section() else { return Ok(()) };
    for edge in 0..polygon.corners().len() {
        for fraction in [0.0, 0.29, 0.71] {
            let mut point = middle(domain);
            (point[0], point[1]) = polygon.on_edge(edge, fraction).into();
            point[axis] = domain.end(axis, lift.functional.side());
            let x = Series::plain(point);
            for own in edges.lifts(edge) {
                if let Functional::End { value, side, .. } = &lift.functional
                    && own.slope != 0.0
                    && along(value, own.outwards(), &x).value().abs() > 1e-10
                {
                    return Err(varies(&domain.face(axis, *side), &format!("edge {edge}")));
                }
                let data = &own.data;
                let implied = lift.functional.apply(data, axis, domain.ends(axis), &x).value();
                let asked = own.apply(&lift.data, &x).value();
                let size = magnitude(data, domain) + magnitude(&lift.data, domain);
                if differ(implied, asked, size) {
                    let face = domain.face(axis, lift.functional.side());
                    let corner = format!("{face}, polygon edge at ({}, {})", point[0], point[1]);
                    return Err(conflict(&corner, implied, asked));
                }
            }
        }
    }
    Ok(())
}

fn middle<const D: usize>(domain: &Domain<D>) -> [f64; D] {
    std::array::from_fn(|d| 0.5 * (domain.lower()[d] + domain.upper()[d]))
}

/// Whether the functional of one face, applied to the data of the other, gives what the other's
/// functional makes of the first's data.
fn check_corner<const D: usize>(
    problem: &Problem<D>,
    (first, a): (usize, &Lift<D>),
    (second, b): (usize, &Lift<D>),
) -> Result<(), GpError> {
    let domain = problem.domain();
    for fraction in CORNER_SAMPLES {
        let mut point: [f64; D] =
            std::array::from_fn(|d| domain.lower()[d] + fraction * domain.extents()[d]);
        point[first] = domain.end(first, a.functional.side());
        point[second] = domain.end(second, b.functional.side());
        for ((axis, own), (other, functional)) in
            [((first, a), (second, &b.functional)), ((second, b), (first, &a.functional))]
        {
            let Functional::End { value, side, .. } = &own.functional else { continue };
            let passes =
                functional.lets_pass(value, other, domain.ends(other), &Series::plain(point));
            if !value.is_zero() && !passes {
                let along = domain.face(other, functional.side());
                return Err(varies(&domain.face(axis, *side), &along));
            }
        }
        // ∂ along `second` of the first face's data, against ∂ along `first` of the second's.
        let x = Series::plain(point);
        let implied = b.functional.apply(&a.data, second, domain.ends(second), &x).value();
        let asked = a.functional.apply(&b.data, first, domain.ends(first), &x).value();
        let size = magnitude(&a.data, domain) + magnitude(&b.data, domain);
        if differ(implied, asked, size) {
            let corner = format!(
                "{}, {}",
                domain.face(first, a.functional.side()),
                domain.face(second, b.functional.side())
            );
            return Err(conflict(&corner, implied, asked));
        }
    }
    Ok(())
}

/// What the condition of one face implies at a corner, and what that of the other asks for.
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
