//! When a follower pressure has a potential: what its surface's rim must be.

use crate::SceneError;
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
    facets: &[[usize; 3]],
    points: &[[f64; 3]],
    prescribed: &[Option<f64>],
) -> Result<[f64; 3], SceneError> {
    let size = extent(facets, points);
    let mut planes = [None; 3];
    for [a, b] in rim(facets) {
        if [a, b].iter().all(|&node| (0..3).all(|i| prescribed[3 * node + i].is_some())) {
            continue;
        }
        let place = |node: usize, i: usize| prescribed[3 * node + i].map(|u| points[node][i] + u);
        let in_plane = (0..3).find_map(|i| {
            let (at, other) = (place(a, i)?, place(b, i)?);
            ((at - other).abs() <= PLANE_TOLERANCE * size).then_some((i, at))
        });
        let Some((axis, second)) = in_plane else {
            return Err(SceneError::LooseRim { name: name.into(), edge: [a, b] });
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

/// Edges that belong to one facet only, ascending.
fn rim(facets: &[[usize; 3]]) -> Vec<[usize; 2]> {
    let mut owners = HashMap::new();
    for [a, b, c] in facets {
        for (x, y) in [(a, b), (b, c), (c, a)] {
            *owners.entry([*x.min(y), *x.max(y)]).or_insert(0) += 1;
        }
    }
    let mut edges: Vec<_> = owners.into_iter().filter(|o| o.1 == 1).map(|o| o.0).collect();
    edges.sort_unstable();
    edges
}

fn extent(facets: &[[usize; 3]], points: &[[f64; 3]]) -> f64 {
    let nodes = || facets.as_flattened().iter().map(|&node| points[node]);
    let width = |i: usize| {
        let (least, most) = nodes()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), x| (l.min(x[i]), m.max(x[i])));
        most - least
    };
    (0..3).map(width).fold(0.0, f64::max)
}
