//! Structured meshes of simple bodies.

mod biventricle;
mod chamber;
mod implicit;
mod liver;
mod membrane;
mod population;
mod shells;
mod ventricle;
mod wall;

pub use biventricle::Biventricle;
pub use chamber::{Chamber, ChamberError, ChamberReport, ChamberWall, Size, Trim, WallOptions};
pub use liver::IdealLiver;
pub use membrane::cook_membrane;
pub use population::{ShapeError, VentricleShape};
pub use shells::{cylinder_quarter, sphere_octant};
pub use ventricle::TruncatedEllipsoid;
pub use wall::Wall;

use crate::{HexMesh, Mesh, TetMesh, TriangleMesh, boundary_facets, repair_orientation};

const AXES: [&str; 3] = ["x", "y", "z"];

/// A box `[0, extent]` of `cells` grid cells per axis, each split into six Kuhn tetrahedra
/// around its main diagonal (H. W. Kuhn, "Some combinatorial lemmas in topology", 1960).
///
/// Nodes and grid cells run with x fastest; the six tetrahedra of a grid cell follow each
/// other. Neighbouring grid cells match without hanging nodes. The six sides are node sets
/// and facet sets named `x_min`, `x_max`, `y_min`, `y_max`, `z_min` and `z_max`.
///
/// # Panics
/// When an extent is not positive and finite or a cell count is zero.
///
/// ```
/// let beam = sinew_mesh::box_tetrahedra([10.0, 1.0, 1.0], [12, 4, 5]);
/// assert_eq!((beam.points.len(), beam.cells.len()), (390, 1440));
/// assert_eq!(beam.node_sets["x_min"].len(), 30);
/// ```
pub fn box_tetrahedra(extent: [f64; 3], cells: [usize; 3]) -> TetMesh {
    let permutations = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    kuhn_grid(extent, cells, &permutations)
}

/// A rectangle `[0, extent]` in the plane `z = 0`, each grid cell split into two
/// counterclockwise triangles along its main diagonal; order and names as in
/// [`box_tetrahedra`], without the z sides.
///
/// # Panics
/// When an extent is not positive and finite or a cell count is zero.
///
/// ```
/// let plate = sinew_mesh::rectangle_triangles([2.0, 1.0], [4, 2]);
/// assert_eq!((plate.points.len(), plate.cells.len()), (15, 16));
/// ```
pub fn rectangle_triangles(extent: [f64; 2], cells: [usize; 2]) -> TriangleMesh {
    kuhn_grid(extent, cells, &[[0, 1], [1, 0]])
}

/// A box `[0, extent]` of `cells` hexahedra per axis; order and names as in [`box_tetrahedra`].
///
/// # Panics
/// When an extent is not positive and finite or a cell count is zero.
///
/// ```
/// let beam = sinew_mesh::box_hexahedra([10.0, 1.0, 1.0], [12, 4, 5]);
/// assert_eq!((beam.points.len(), beam.cells.len()), (390, 240));
/// assert_eq!(beam.facet_sets["x_max"].len(), 20);
/// ```
pub fn box_hexahedra(extent: [f64; 3], cells: [usize; 3]) -> HexMesh {
    let (mut mesh, stride) = grid_points(extent, cells);
    let [x, y, z] = stride;
    for at in grid(cells) {
        let lowest: usize = (0..3).map(|axis| at[axis] * stride[axis]).sum();
        let bottom = [lowest, lowest + x, lowest + x + y, lowest + y];
        let [a, b, c, d] = bottom;
        mesh.cells.push([a, b, c, d, a + z, b + z, c + z, d + z]);
    }
    name_sides(&mut mesh, extent);
    mesh
}

/// The grid in `D` dimensions; each order of the axes is one simplex, whose vertices are met
/// on the walk along the grid cell's edges from its lowest corner to the opposite one.
fn kuhn_grid<const D: usize, const N: usize>(
    extent: [f64; D],
    cells: [usize; D],
    axis_orders: &[[usize; D]],
) -> Mesh<N> {
    let (mut mesh, stride) = grid_points(extent, cells);
    for at in grid(cells) {
        let lowest: usize = (0..D).map(|axis| at[axis] * stride[axis]).sum();
        for order in axis_orders {
            let mut walk = [lowest; N];
            for (step, &axis) in order.iter().enumerate() {
                walk[step + 1] = walk[step] + stride[axis];
            }
            mesh.cells.push(walk);
        }
    }
    repair_orientation(&mut mesh);
    name_sides(&mut mesh, extent);
    mesh
}

/// The nodes of a grid as a mesh without cells, and the steps between neighbours.
fn grid_points<const D: usize, const N: usize>(
    extent: [f64; D],
    cells: [usize; D],
) -> (Mesh<N>, [usize; D]) {
    assert!(
        extent.iter().all(|e| e.is_finite() && *e > 0.0) && cells.iter().all(|&n| n > 0),
        "extents must be positive and cell counts at least 1, not {extent:?} and {cells:?}"
    );
    let nodes = cells.map(|n| n + 1);
    let stride: [usize; D] = std::array::from_fn(|axis| nodes[..axis].iter().product());
    let position = |at: [usize; D]| {
        let mut point = [0.0; 3];
        for axis in 0..D {
            point[axis] = grid_coordinate(at[axis], cells[axis], extent[axis]);
        }
        point
    };
    let points = grid(nodes).map(position).collect();
    (Mesh { points, ..Mesh::default() }, stride)
}

/// All indices of a grid, the first axis fastest.
fn grid<const D: usize>(count: [usize; D]) -> impl Iterator<Item = [usize; D]> {
    (0..count.iter().product()).map(move |mut index: usize| {
        count.map(|n| {
            let at = index % n;
            index /= n;
            at
        })
    })
}

/// The ends are exact; in between as `numpy.linspace`, so that meshes agree bit for bit.
fn grid_coordinate(index: usize, cells: usize, extent: f64) -> f64 {
    if index == cells { extent } else { index as f64 * (extent / cells as f64) }
}

/// Names the sides of a box.
fn name_sides<const D: usize, const N: usize>(mesh: &mut Mesh<N>, extent: [f64; D]) {
    let boundary = boundary_facets(mesh);
    for axis in 0..D {
        for (end, level) in [("min", 0.0), ("max", extent[axis])] {
            mesh.name_side(&boundary, &format!("{}_{end}", AXES[axis]), |x| x[axis] == level);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Facet, enclosed_volume};

    /// A solid whose cells are positive at and between their nodes, fit together (what is not shared
    /// is on a named side) and fill what the boundary encloses. Returns its volume.
    pub(super) fn assert_sound<const N: usize>(mesh: &Mesh<N>) -> f64 {
        assert_eq!(mesh.check(), Ok(()));
        let element = Mesh::<N>::ELEMENT;
        let centre: [f64; 3] = std::array::from_fn(|axis| {
            element.nodes.iter().map(|at| at[axis]).sum::<f64>() / N as f64
        });
        for cell in 0..mesh.cells.len() {
            for node in element.nodes {
                for way in [0.0, 0.4, 0.8, 1.0] {
                    let at = std::array::from_fn(|i| way * node[i] + (1.0 - way) * centre[i]);
                    assert!(mesh.jacobian(cell, at) > 0.0, "cell {cell} at {at:?}");
                }
            }
        }
        let boundary = boundary_facets(mesh);
        let mut named: Vec<Facet> = mesh.facet_sets.values().flatten().copied().collect();
        named.sort_unstable();
        assert_eq!(named, boundary);
        let volume: f64 = (0..mesh.cells.len()).map(|cell| mesh.cell_volume(cell)).sum();
        assert!((enclosed_volume(mesh, &boundary) / volume - 1.0).abs() < 1e-12);
        volume
    }

    #[test]
    fn hexahedra_fill_the_box() {
        let mesh = box_hexahedra([2.0, 3.0, 4.0], [2, 1, 3]);
        assert!((assert_sound(&mesh) - 24.0).abs() < 1e-13);
        assert_eq!(mesh.points, box_tetrahedra([2.0, 3.0, 4.0], [2, 1, 3]).points);
        assert_eq!(mesh.cells[0], [0, 1, 4, 3, 6, 7, 10, 9]);
        assert_eq!(mesh.facet_sets["z_max"], [4, 5].map(|cell| Facet { cell, opposite: 5 }));
    }

    #[test]
    fn the_first_grid_cell_is_split_as_published() {
        let mesh = box_tetrahedra([2.0, 3.0, 4.0], [2, 1, 1]);
        assert_eq!(mesh.points[0], [0.0, 0.0, 0.0]);
        assert_eq!(mesh.points[1], [1.0, 0.0, 0.0]);
        assert_eq!(mesh.points[3], [0.0, 3.0, 0.0]);
        assert_eq!(mesh.points[6], [0.0, 0.0, 4.0]);
        // Walks 0 -> 10 over strides 1, 3, 6; odd axis orders have vertices 1 and 2 swapped.
        let expected = [
            [0, 1, 4, 10],
            [0, 7, 1, 10],
            [0, 4, 3, 10],
            [0, 3, 9, 10],
            [0, 6, 7, 10],
            [0, 9, 6, 10],
        ];
        assert_eq!(mesh.cells[..6], expected);
    }

    #[test]
    fn simplices_fill_the_box_and_the_rectangle() {
        assert!((assert_sound(&box_tetrahedra([10.0, 1.0, 2.0], [5, 2, 3])) - 20.0).abs() < 1e-12);
        let plate = rectangle_triangles([3.0, 2.0], [4, 3]);
        let area: f64 = (0..plate.cells.len()).map(|c| plate.cell_volume(c)).sum();
        assert!((area - 6.0).abs() < 1e-13);
    }

    #[test]
    fn sides_are_complete() {
        let mesh = box_tetrahedra([1.0, 1.0, 1.0], [2, 3, 4]);
        assert_eq!(mesh.node_sets["x_min"].len(), 4 * 5);
        assert_eq!(mesh.node_sets["z_max"].len(), 3 * 4);
        assert_eq!(mesh.facet_sets["x_max"].len(), 2 * 3 * 4);
        assert_eq!(mesh.facet_sets["y_min"].len(), 2 * 2 * 4);
        let plate = rectangle_triangles([1.0, 1.0], [2, 3]);
        assert_eq!(plate.facet_sets["x_min"].len(), 3);
        assert_eq!(plate.node_sets.len(), 4);
    }
}
