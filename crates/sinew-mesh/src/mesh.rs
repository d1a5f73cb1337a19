//! The mesh itself: nodes, cells, named sets and fields.

use std::collections::BTreeMap;

/// A mesh of cells with `N` nodes each, which tell their kind: see [`TetMesh`], [`TriangleMesh`],
/// [`QuadraticTetMesh`], [`QuadraticTriangleMesh`], [`HexMesh`] and [`Mesh::ELEMENT`].
///
/// Points always have three coordinates (a plane mesh has `z = 0`), so files, graphs and
/// fields need one design only. The nodes of a cell stand in the order of VTK.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh<const N: usize> {
    /// Node positions, one row per node [length unit of the scene].
    pub points: Vec<[f64; 3]>,
    /// Node indices of each cell; a solid cell has positive volume, see [`crate::repair_orientation`].
    pub cells: Vec<[usize; N]>,
    /// Named sets of node indices, ascending.
    pub node_sets: BTreeMap<String, Vec<usize>>,
    /// Named sets of facets.
    pub facet_sets: BTreeMap<String, Vec<Facet>>,
    /// Named sets of cell indices, ascending.
    pub cell_sets: BTreeMap<String, Vec<usize>>,
    /// Named fields with one row per node.
    pub point_fields: BTreeMap<String, Field>,
    /// Named fields with one row per cell.
    pub cell_fields: BTreeMap<String, Field>,
}
/// Tetrahedra.
pub type TetMesh = Mesh<4>;
/// Triangles.
pub type TriangleMesh = Mesh<3>;
/// Quadratic tetrahedra: four corners, then the nodes of the edges 01, 12, 20, 03, 13, 23.
pub type QuadraticTetMesh = Mesh<10>;
/// Quadratic triangles: three corners, then the nodes of the edges 01, 12, 20.
pub type QuadraticTriangleMesh = Mesh<6>;
/// Trilinear hexahedra: four corners around the bottom, counterclockwise seen from the top, then
/// the four above them.
pub type HexMesh = Mesh<8>;

/// One side of a cell. In simplices it is named by the corner that it leaves out, in hexahedra by
/// its number among the [`crate::Element::facets`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Facet {
    /// Index of the cell.
    pub cell: usize,
    /// Local index of the corner that the facet leaves out; in hexahedra the number of the facet:
    /// 0 to 5 for the sides at the lower and upper end of the first, second and third local axis.
    pub opposite: usize,
}

/// A field of `components` numbers per node or cell, stored row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Numbers per row: 1 scalar, 3 vector, 9 tensor.
    pub components: usize,
    /// The numbers, `rows × components`.
    pub values: FieldValues,
}

/// Number type of a [`Field`], kept so that a round trip through a file is exact.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldValues {
    /// Floating-point numbers.
    Float(Vec<f64>),
    /// Integers, such as region labels.
    Integer(Vec<i64>),
}
