//! Crossed triangles and Cook's membrane.

use super::{grid, grid_points, name_sides};
use crate::TriangleMesh;

/// A rectangle `[0, extent]` in the plane `z = 0`, each grid cell split into four counterclockwise
/// triangles around its centre: free of the preferred direction of [`crate::rectangle_triangles`].
///
/// The nodes of the grid come first, x fastest, then the centres. The sides are node sets and facet
/// sets named `x_min`, `x_max`, `y_min` and `y_max`.
fn rectangle_crossed_triangles(extent: [f64; 2], cells: [usize; 2]) -> TriangleMesh {
    let (mut mesh, [x, y]) = grid_points::<2, 3>(extent, cells);
    for [i, j] in grid(cells) {
        let lowest = i * x + j * y;
        let corners = [lowest, lowest + x, lowest + x + y, lowest + y];
        let centre = mesh.points.len();
        let [low, high] = [corners[0], corners[2]].map(|node| mesh.points[node]);
        mesh.points.push(std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis])));
        mesh.cells.extend((0..4).map(|k| [corners[k], corners[(k + 1) % 4], centre]));
    }
    name_sides(&mut mesh, extent);
    mesh
}

/// Cook's membrane of `boxes` × `boxes` quadrilaterals, each split into four triangles around its
/// centre: the panel with the corners (0, 0), (48, 44), (48, 60), (0, 44) (R. D. Cook, J. Struct. Div.
/// ASCE 100, 1974). The clamped side is the set `x_min`, the loaded one `x_max`; `y_min` and `y_max` are free.
///
/// # Panics
/// When there is no box.
///
/// ```
/// let membrane = sinew_mesh::cook_membrane(16);
/// assert_eq!(membrane.cells.len(), 4 * 16 * 16);
/// let area: f64 = (0..membrane.cells.len()).map(|cell| membrane.cell_volume(cell)).sum();
/// assert!((area - 1440.0).abs() < 1e-10);
/// let quadratic = membrane.quadratic();
/// assert_eq!(quadratic.node_sets["x_max"].len(), 33);
/// ```
pub fn cook_membrane(boxes: usize) -> TriangleMesh {
    let mut mesh = rectangle_crossed_triangles([1.0; 2], [boxes; 2]);
    mesh.map_points(|[x, y, z]| [48.0 * x, 44.0 * x + (44.0 - 28.0 * x) * y, z]);
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary_facets;

    #[test]
    fn crossed_triangles_fill_the_rectangle() {
        let mesh = rectangle_crossed_triangles([3.0, 2.0], [3, 4]);
        assert_eq!(mesh.check(), Ok(()));
        let areas: Vec<f64> = (0..mesh.cells.len()).map(|cell| mesh.cell_volume(cell)).collect();
        assert!(areas.iter().all(|area| (area - 0.125).abs() < 1e-15));
        assert_eq!(mesh.facet_sets["x_max"].len(), 4);
        let sides: usize = mesh.facet_sets.values().map(Vec::len).sum();
        assert_eq!(sides, boundary_facets(&mesh).len());
        assert_eq!(mesh.node_sets["y_max"], [16, 17, 18, 19]);
    }

    #[test]
    fn the_membrane_has_its_corners() {
        let mesh = cook_membrane(2);
        let corners = [0, 2, 6, 8].map(|node| mesh.points[node]);
        let expected = [[0.0, 0.0], [48.0, 44.0], [0.0, 44.0], [48.0, 60.0]];
        assert_eq!(corners, expected.map(|[x, y]| [x, y, 0.0]));
        assert!(mesh.node_sets["x_max"].iter().all(|&node| mesh.points[node][0] == 48.0));
    }

    #[test]
    #[should_panic(expected = "cell counts at least 1")]
    fn no_boxes_are_refused() {
        cook_membrane(0);
    }
}
