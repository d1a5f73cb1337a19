//! Cook's membrane.

use super::{grid, grid_points, name_sides};
use crate::TriangleMesh;

/// Cook's membrane of `boxes` × `boxes` quadrilaterals, each split into four triangles around its centre, free of the preferred
/// direction of [`crate::rectangle_triangles`]. It is the panel with the corners (0, 0), (48, 44), (48, 60), (0, 44) (R. D. Cook,
/// J. Struct. Div. ASCE 100, 1974). The clamped side is the set `x_min`, the loaded one `x_max`; `y_min` and `y_max` are free.
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
    let (extent, cells) = ([1.0; 2], [boxes; 2]);
    let (mut mesh, [x, y]) = grid_points::<2, 3>(extent, cells);
    // The nodes of the grid come first, then the centres.
    for [i, j] in grid(cells) {
        let lowest = i * x + j * y;
        let corners = [lowest, lowest + x, lowest + x + y, lowest + y];
        let centre = mesh.points.len();
        let [low, high] = [corners[0], corners[2]].map(|node| mesh.points[node]);
        mesh.points.push(std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis])));
        mesh.cells.extend((0..4).map(|k| [corners[k], corners[(k + 1) % 4], centre]));
    }
    name_sides(&mut mesh, extent);
    mesh.map_points(|[x, y, z]| [48.0 * x, 44.0 * x + (44.0 - 28.0 * x) * y, z]);
    mesh
}
