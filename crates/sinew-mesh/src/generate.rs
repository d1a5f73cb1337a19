//! Structured meshes of simple bodies.

mod biventricle;
mod chamber;
mod implicit;
mod ventricle;
mod wall;

pub use biventricle::Biventricle;
pub use chamber::{Chamber, ChamberReport, ChamberWall, Size, Trim, WallOptions};
pub use ventricle::TruncatedEllipsoid;
pub use wall::{Sheet, Wall};

use crate::{HexMesh, Mesh, TetMesh, TriangleMesh, boundary_facets, repair_orientation};

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
    structured(extent, cells, |[x, y, z]| vec![[0, x, x + y, y, z, x + z, x + y + z, y + z]])
}

/// The grid in `D` dimensions; each order of the axes is one simplex, whose vertices are met
/// on the walk along the grid cell's edges from its lowest corner to the opposite one.
fn kuhn_grid<const D: usize, const N: usize>(
    extent: [f64; D],
    cells: [usize; D],
    orders: &[[usize; D]],
) -> Mesh<N> {
    let walk = |order: &[usize; D], stride: [usize; D]| {
        std::array::from_fn(|step| order[..step].iter().map(|&axis| stride[axis]).sum())
    };
    structured(extent, cells, |stride| orders.iter().map(|order| walk(order, stride)).collect())
}

/// The grid in `D` dimensions; each of its cells is divided alike, into cells of nodes so many steps behind its lowest corner.
fn structured<const D: usize, const N: usize>(
    extent: [f64; D],
    cells: [usize; D],
    divide: impl FnOnce([usize; D]) -> Vec<[usize; N]>,
) -> Mesh<N> {
    assert!(
        extent.iter().all(|e| e.is_finite() && *e > 0.0) && cells.iter().all(|&n| n > 0),
        "extents must be positive and cell counts at least 1, not {extent:?} and {cells:?}"
    );
    let nodes = cells.map(|n| n + 1);
    let stride: [usize; D] = std::array::from_fn(|axis| nodes[..axis].iter().product());
    let along = |at: [usize; D], i: usize| grid_coordinate(at[i], cells[i], extent[i]);
    let position = |at| std::array::from_fn(|axis| if axis < D { along(at, axis) } else { 0.0 });
    let mut mesh = Mesh { points: grid(nodes).map(position).collect(), ..Mesh::default() };
    let parts = divide(stride);
    for at in grid(cells) {
        let lowest: usize = (0..D).map(|axis| at[axis] * stride[axis]).sum();
        mesh.cells.extend(parts.iter().map(|part| part.map(|step| lowest + step)));
    }
    repair_orientation(&mut mesh);
    let boundary = boundary_facets(&mesh);
    for axis in 0..D {
        for (end, level) in [("min", 0.0), ("max", extent[axis])] {
            mesh.name_side(&boundary, &format!("{}_{end}", ["x", "y", "z"][axis]), |x| {
                x[axis] == level
            });
        }
    }
    mesh
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
