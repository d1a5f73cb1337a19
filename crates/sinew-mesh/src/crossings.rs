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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{boundary_facets, box_tetrahedra, extract_surface};

    fn cube(at: f64) -> TriangleMesh {
        let mesh = box_tetrahedra([1.0; 3], [3; 3]);
        let mut surface = extract_surface(&mesh, &boundary_facets(&mesh)).mesh;
        // Different along each axis: edges that meet edges touch only.
        surface
            .points
            .iter_mut()
            .for_each(|[x, y, z]| (*x, *y, *z) = (*x + at, *y + 1.1 * at, *z + 1.3 * at));
        surface
    }

    fn both(mut a: TriangleMesh, b: TriangleMesh) -> TriangleMesh {
        let step = a.points.len();
        a.points.extend(b.points);
        a.cells.extend(b.cells.iter().map(|cell| cell.map(|node| node + step)));
        a
    }

    #[test]
    fn sound_and_nested_surfaces_do_not_cross() {
        let mut small = cube(0.0);
        small.points.iter_mut().for_each(|x| *x = x.map(|x| 0.25 + 0.5 * x));
        assert!(self_intersections(&both(cube(0.0), small)).is_empty());
        // Twice the same surface touches everywhere.
        assert!(self_intersections(&both(cube(0.0), cube(0.0))).is_empty());
    }

    #[test]
    fn overlapping_cubes_cross() {
        let found = self_intersections(&both(cube(0.0), cube(0.41)));
        let count = cube(0.0).cells.len();
        assert!(!found.is_empty(), "nothing was found");
        let wrong: Vec<_> = found.iter().filter(|[a, b]| *a >= count || *b < count).collect();
        assert!(wrong.is_empty(), "{count} {wrong:?}");
    }

    #[test]
    fn a_spike_through_its_own_surface_is_found() {
        let mut surface = cube(0.0);
        let middle = surface.points.iter().position(|&x| x == [1.0 / 3.0, 1.0 / 3.0, 1.0]).unwrap();
        surface.points[middle] = [0.4, 0.45, -0.5];
        assert!(!self_intersections(&surface).is_empty());
    }
}
