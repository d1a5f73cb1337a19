//! Cook's membrane. Included by the tests and studies of other crates, too.

use sinew_mesh::{TriangleMesh, rectangle_triangles};

/// Cook's membrane of `boxes` × `boxes` quadrilaterals, each split into four triangles around its centre, free of the preferred
/// direction of [`rectangle_triangles`]. It is the panel with the corners (0, 0), (48, 44), (48, 60), (0, 44) (R. D. Cook,
/// J. Struct. Div. ASCE 100, 1974). The clamped side is the set `x_min`, the loaded one `x_max`; `y_min` and `y_max` are free.
///
/// # Panics
/// When there is no box.
pub(crate) fn cook_membrane(boxes: usize) -> TriangleMesh {
    let square = rectangle_triangles([1.0; 2], [boxes; 2]);
    let mut mesh = TriangleMesh { points: square.points, ..TriangleMesh::default() };
    // The nodes of the grid come first, then the centres.
    for (i, j) in (0..boxes * boxes).map(|at| (at % boxes, at / boxes)) {
        let lowest = i + j * (boxes + 1);
        let corners = [lowest, lowest + 1, lowest + boxes + 2, lowest + boxes + 1];
        let centre = mesh.points.len();
        let [low, high] = [corners[0], corners[2]].map(|node| mesh.points[node]);
        mesh.points.push(std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis])));
        mesh.cells.extend((0..4).map(|k| [corners[k], corners[(k + 1) % 4], centre]));
    }
    for (name, axis, level) in
        [("x_min", 0, 0.0), ("x_max", 0, 1.0), ("y_min", 1, 0.0), ("y_max", 1, 1.0)]
    {
        mesh.name_nodes(name, |x| x[axis] == level);
        mesh.name_facets(name, |x| x[axis] == level);
    }
    mesh.map_points(|[x, y, z]| [48.0 * x, 44.0 * x + (44.0 - 28.0 * x) * y, z]);
    mesh
}
