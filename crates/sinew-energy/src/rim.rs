//! When a follower pressure has a potential: what its surface's rim must be.

use crate::lower::Held;
use crate::{FacetRule, SceneError};
use std::collections::HashMap;

/// How far apart two coordinates [relative to the size of the surface] count as the same plane.
const PLANE_TOLERANCE: f64 = 1e-9;

/// Origin for the enclosed volume of a surface.
///
/// The volume `⅓∫ x·n da` is a potential of the pressure when each edge of the rim is held, or slides
/// in a coordinate plane through the origin: then the cone over the rim adds nothing that moves.
/// Where no edge slides across an axis the origin is arbitrary; the surface's first node keeps the
/// numbers small.
///
/// # Errors
/// [`SceneError::LooseRim`] and [`SceneError::RimPlanes`].
pub(crate) fn rim_origin(
    name: &str,
    rule: &FacetRule,
    facets: &[Vec<usize>],
    points: &[[f64; 3]],
    held: &Held,
) -> Result<[f64; 3], SceneError> {
    let size = extent(facets, points);
    let mut planes = [None; 3];
    let axes = 0..rule.dimension;
    for piece in rim(rule, facets) {
        let is_held = |&node: &usize| axes.clone().all(|i| held.prescribed[3 * node + i].is_some());
        if piece.iter().all(is_held) {
            continue;
        }
        let place = |node: usize, i: usize| held.along_axis(node, i).map(|u| points[node][i] + u);
        let in_plane = axes.clone().find_map(|i| {
            let at = place(piece[0], i)?;
            let near = |&node: &usize| {
                place(node, i).is_some_and(|other| (at - other).abs() <= PLANE_TOLERANCE * size)
            };
            piece.iter().all(near).then_some((i, at))
        });
        let Some((axis, second)) = in_plane else {
            let edge = [piece[0], piece[piece.len().min(2) - 1]];
            return Err(SceneError::LooseRim { name: name.into(), edge });
        };
        let first = *planes[axis].get_or_insert(second);
        if (first - second).abs() > PLANE_TOLERANCE * size {
            let axis = ['x', 'y', 'z'][axis];
            return Err(SceneError::RimPlanes { name: name.into(), axis, first, second });
        }
    }
    let near = facets.first().map_or([0.0; 3], |facet| points[facet[0]]);
    Ok(std::array::from_fn(|i| planes[i].unwrap_or(near[i])))
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

fn extent(facets: &[Vec<usize>], points: &[[f64; 3]]) -> f64 {
    let nodes = || facets.iter().flatten().map(|&node| points[node]);
    let width = |i: usize| {
        let (least, most) = nodes()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), x| (l.min(x[i]), m.max(x[i])));
        most - least
    };
    (0..3).map(width).fold(0.0, f64::max)
}
