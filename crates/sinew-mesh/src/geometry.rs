//! Volumes and orientation.

use nalgebra::Vector3;

use crate::SimplexMesh;

impl<const V: usize> SimplexMesh<V> {
    /// The corners of a cell as vectors.
    pub fn corners(&self, cell: usize) -> [Vector3<f64>; V] {
        self.cells[cell].map(|node| Vector3::from(self.points[node]))
    }

    /// Volume of a tetrahedron, negative when its vertices 1, 2, 3 run clockwise seen from
    /// outside, or area of a triangle, which is never negative [length unit cubed or squared].
    pub fn cell_volume(&self, cell: usize) -> f64 {
        const { assert!(V == 3 || V == 4, "cells are triangles or tetrahedra") };
        let corners = self.corners(cell);
        let [a, b, c] = [1, 2, V - 1].map(|i| corners[i] - corners[0]);
        if V == 4 { a.cross(&b).dot(&c) / 6.0 } else { a.cross(&b).norm() / 2.0 }
    }
}

/// Makes every tetrahedron positive by swapping the local vertices 1 and 2 of the negative
/// ones, and returns how many it swapped. Facet sets keep naming the same facets.
///
/// Triangles are turned counterclockwise where the mesh lies in a plane of constant `z`; on a
/// curved surface no side is the right one, so nothing changes.
pub fn repair_orientation<const V: usize>(mesh: &mut SimplexMesh<V>) -> usize {
    let plane = V == 3 && mesh.points.windows(2).all(|pair| pair[0][2] == pair[1][2]);
    if V == 3 && !plane {
        return 0;
    }
    let mut swapped = vec![false; mesh.cells.len()];
    for cell in 0..mesh.cells.len() {
        let corners = mesh.corners(cell);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let orientation =
            if V == 4 { normal.dot(&(corners[V - 1] - corners[0])) } else { normal.z };
        if orientation < 0.0 {
            mesh.cells[cell].swap(1, 2);
            swapped[cell] = true;
        }
    }
    for facet in mesh.facet_sets.values_mut().flatten().filter(|facet| swapped[facet.cell]) {
        facet.opposite = [0, 2, 1, 3][facet.opposite];
    }
    swapped.iter().filter(|&&s| s).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Facet, TetMesh, TriangleMesh};

    fn corner_tet(cell: [usize; 4]) -> TetMesh {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        TetMesh { points, cells: vec![cell], ..TetMesh::default() }
    }

    #[test]
    fn signed_volume() {
        assert_eq!(corner_tet([0, 1, 2, 3]).cell_volume(0), 1.0 / 6.0);
        assert_eq!(corner_tet([0, 2, 1, 3]).cell_volume(0), -1.0 / 6.0);
    }

    #[test]
    fn repair_counts_and_keeps_facets() {
        let mut mesh = corner_tet([0, 2, 1, 3]);
        mesh.facet_sets.insert("slanted".into(), vec![Facet { cell: 0, opposite: 0 }]);
        mesh.facet_sets.insert("x".into(), vec![Facet { cell: 0, opposite: 2 }]);
        assert_eq!(repair_orientation(&mut mesh), 1);
        assert_eq!(mesh.cells, [[0, 1, 2, 3]]);
        assert_eq!(mesh.facet_sets["slanted"], [Facet { cell: 0, opposite: 0 }]);
        assert_eq!(mesh.facet_sets["x"], [Facet { cell: 0, opposite: 1 }]);
        assert_eq!(repair_orientation(&mut mesh), 0);
    }

    #[test]
    fn triangles_are_turned_in_the_plane_only() {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mut mesh = TriangleMesh { points, cells: vec![[0, 2, 1]], ..Default::default() };
        assert_eq!(repair_orientation(&mut mesh), 1);
        assert_eq!(mesh.cells, [[0, 1, 2]]);
        mesh.cells = vec![[0, 2, 1]];
        mesh.points[1][2] = 1.0;
        assert_eq!(repair_orientation(&mut mesh), 0);
    }
}
