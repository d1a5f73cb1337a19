//! Surfaces that pass through themselves.

use crate::TriangleMesh;
use crate::geometry::merged;
use crate::tree::{SurfaceTree, crossing};
use nalgebra::Vector3;

/// Least distance of a crossing from ends and edges \[relative to their lengths\]: contact is no crossing.
const MARGIN: f64 = 1e-9;

/// Pairs of triangles that intersect: an edge of one passes through the interior of the other. Coincident points count
/// as one; coplanar triangles are not found.
///
/// ```
/// use sinew_mesh::{TriangleMesh, self_intersections};
///
/// let points = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.5, 0.5, -1.0], [0.6, 0.5, 1.0], [0.5, 0.6, 1.0]];
/// let mut surface = TriangleMesh::new(points, vec![[0, 1, 2], [3, 4, 5]])?;
/// assert_eq!(self_intersections(&surface), [[0, 1]]);
/// surface.points[3][2] = 0.5;
/// assert!(self_intersections(&surface).is_empty());
/// # Ok::<(), sinew_mesh::Defect>(())
/// ```
pub fn self_intersections(surface: &TriangleMesh) -> Vec<[usize; 2]> {
    let tree = SurfaceTree::new(surface);
    let place = merged(&surface.points, 0.0);
    let named = |cell: usize| surface.cells[cell].map(|node| place[node]);
    let mut pairs = Vec::new();
    for cell in 0..surface.cells.len() {
        let corners = surface.corners(cell);
        let low = corners[0].inf(&corners[1]).inf(&corners[2]);
        let high = corners[0].sup(&corners[1]).sup(&corners[2]);
        for other in tree.near(low, high) {
            if other <= cell {
                continue;
            }
            let of_other = surface.corners(other);
            let (a, b) = (named(cell), named(other));
            if pierces((a, &corners), (b, &of_other)) || pierces((b, &of_other), (a, &corners)) {
                pairs.push([cell, other]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// Whether an edge of the first triangle passes through the second; edges that share an end with it do not count.
fn pierces(
    (names, corners): ([usize; 3], &[Vector3<f64>; 3]),
    (others, triangle): ([usize; 3], &[Vector3<f64>; 3]),
) -> bool {
    (0..3).any(|k| {
        let ends = [k, (k + 1) % 3];
        let apart = ends.iter().all(|&end| !others.contains(&names[end]));
        let [from, to] = ends.map(|end| corners[end]);
        let inside = |way: f64| (MARGIN..1.0 - MARGIN).contains(&way);
        apart && crossing(triangle, from, to - from, MARGIN).is_some_and(inside)
    })
}
