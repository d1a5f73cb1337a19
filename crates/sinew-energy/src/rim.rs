//! Conditions on the rim of a surface under which a follower pressure has a potential.

use crate::frames::Held;
use crate::{FacetRule, SceneError};
use sinew_num::Mat3;
use std::collections::HashMap;

/// Largest force lost by the potential at an uneven rim [relative to pressure times area]: a hundredth of the
/// discretisation error of our finest meshes, as displacements change by about the same part.
const MISSED: f64 = 1e-4;

/// Differences of coordinates that count as rounding errors [relative to the root of the area].
const EVEN: f64 = 1e-9;

/// A piece of the rim that slides along a plane across a coordinate axis.
struct Sliding {
    piece: Vec<usize>,
    /// Least and largest position of its nodes on the axis \[length\].
    ends: [f64; 2],
}

/// Least and largest of some numbers.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let all = [f64::INFINITY, f64::NEG_INFINITY];
    values.fold(all, |[least, most], x| [least.min(x), most.max(x)])
}

/// Origin for the enclosed volume of a surface.
///
/// The volume `⅓∫ x·n da` is a potential of the pressure when each edge of the rim is held, or slides
/// in a coordinate plane through the origin: then the cone over the rim adds nothing that moves.
/// A rim that is not quite even misses forces `⅓ p (r × δ) Δz + ⅓ p z (δ × Δr)` per edge Δr from z to z + Δz at a
/// distance r, which are bounded by [`MISSED`].
/// Where no edge slides across an axis the origin is arbitrary; the surface's first node keeps the
/// numbers small.
///
/// # Errors
/// [`SceneError::LooseRim`], and [`SceneError::Loads`] for rims in different planes.
pub(crate) fn rim_origin(
    name: &str,
    rule: &FacetRule,
    facets: &[Vec<usize>],
    points: &[[f64; 3]],
    held: &Held,
) -> Result<[f64; 3], SceneError> {
    let mut origin = facets.first().map_or([0.0; 3], |facet| points[facet[0]]);
    let area: f64 = facets.iter().map(|facet| rule.area(facet, points)).sum();
    let sliding = sliding(name, rule, facets, points, held, EVEN * area.sqrt())?;
    let of_axes = sliding.each_ref().map(|sliding| {
        (!sliding.is_empty()).then(|| ends(sliding.iter().flat_map(|sliding| sliding.ends)))
    });
    for (axis, ends) in of_axes.iter().enumerate() {
        origin[axis] = ends.map_or(origin[axis], |[least, most]| 0.5 * (least + most));
    }
    for (axis, sliding) in sliding.iter().enumerate() {
        let Some([least, most]) = of_axes[axis] else { continue };
        let [tilted, off] = missed(axis, sliding, origin, points).map(|force| force / area);
        let axis = ['x', 'y', 'z'][axis];
        // Written so that a NaN is an error as well.
        if tilted.is_nan() || tilted > MISSED {
            return Err(SceneError::LooseRim(format!(
                "the rim of `{name}` slides across {axis} but is not even: it goes from {axis} = {least} to {axis} = {most}, so that {:.2} % of the pressure's force would be lost, where 0.01 % is allowed; move its nodes into one plane, hold the rim, close it by a lid that moves with it, or solve the balance of forces with a loose rim",
                100.0 * tilted
            )));
        }
        if off.is_nan() || off > MISSED {
            return Err(SceneError::LooseRim(format!(
                "the rim of `{name}` slides in the planes {axis} = {least} and {axis} = {most}; its pressure has a potential for one plane per axis only: hold one of the rims, or solve the balance of forces with a loose rim"
            )));
        }
    }
    Ok(origin)
}

/// Sliding pieces of the rim, by the normal axis of their plane: the axis along which they vary least. Differences up
/// to `even` count as zero.
fn sliding(
    name: &str,
    rule: &FacetRule,
    facets: &[Vec<usize>],
    points: &[[f64; 3]],
    held: &Held,
    even: f64,
) -> Result<[Vec<Sliding>; 3], SceneError> {
    let mut sliding: [Vec<Sliding>; 3] = Default::default();
    let axes = 0..rule.dimension;
    for piece in rim(rule, facets) {
        let is_held = |&node: &usize| axes.clone().all(|i| held.prescribed[3 * node + i].is_some());
        if piece.iter().all(is_held) {
            continue;
        }
        let across = |axis: usize| {
            let along = |node| held.along(node, &Mat3::IDENTITY[axis]);
            let place = |&node: &usize| Some(points[node][axis] + along(node)?);
            let places = piece.iter().map(place).collect::<Option<Vec<_>>>()?;
            Some((axis, Sliding { piece: piece.clone(), ends: ends(places.into_iter()) }))
        };
        // The first of several that are even to rounding errors.
        let uneven = |(_, Sliding { ends, .. }): &(usize, Sliding)| match ends[1] - ends[0] {
            rounding if rounding <= even => 0.0,
            uneven => uneven,
        };
        let most_even =
            axes.clone().filter_map(across).min_by(|a, b| uneven(a).total_cmp(&uneven(b)));
        let Some((axis, piece)) = most_even else {
            let at: Vec<_> = piece.iter().take(2).map(usize::to_string).collect();
            return Err(SceneError::LooseRim(format!(
                "the pressure on `{name}` has no potential: its rim at nodes {} is neither held nor made to slide in one coordinate plane; hold the rim, close it by a lid that moves with it, or solve the balance of forces with a loose rim",
                at.join(" and ")
            )));
        };
        sliding[axis].push(piece);
    }
    Ok(sliding)
}

/// Bounds of the forces lost by the potential per pressure \[area\]: from variations along each piece, and from pieces
/// off the plane through the origin.
fn missed(axis: usize, sliding: &[Sliding], origin: [f64; 3], points: &[[f64; 3]]) -> [f64; 2] {
    let distance = |a: [f64; 3], b: [f64; 3]| {
        let apart = (0..3).filter(|&i| i != axis).map(|i| (a[i] - b[i]).powi(2));
        apart.sum::<f64>().sqrt()
    };
    let mut sums = [0.0; 2];
    for Sliding { piece, ends: [least, most] } in sliding {
        let [first, second] = [piece[0], piece[piece.len().min(2) - 1]];
        // The end of a line has a width of one.
        let length = if first == second { 1.0 } else { distance(points[first], points[second]) };
        let away = distance(points[first], origin).max(distance(points[second], origin));
        let height = (most - origin[axis]).abs().max((least - origin[axis]).abs());
        sums[0] += away * (most - least) / 3.0;
        sums[1] += height * length / 3.0;
    }
    sums
}

/// Pieces of the rim, ascending: what belongs to one facet only, edges of a surface (ends first, then the
/// node between them, if any) or ends of a line.
fn rim(rule: &FacetRule, facets: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut owners = HashMap::new();
    for nodes in facets {
        for a in 0..rule.corners {
            let mut piece = vec![nodes[a]];
            if rule.dimension == 3 {
                piece.push(nodes[(a + 1) % rule.corners]);
                piece.sort_unstable();
                piece.extend(nodes.get(rule.corners + a));
            }
            *owners.entry(piece).or_insert(0) += 1;
        }
    }
    let mut pieces: Vec<_> = owners.into_iter().filter(|o| o.1 == 1).map(|o| o.0).collect();
    pieces.sort_unstable();
    pieces
}
