//! The mesh itself: nodes, simplices, named sets and fields.

use std::collections::BTreeMap;

/// A mesh of simplices with `V` vertices each: `V = 4` are tetrahedra, `V = 3` triangles.
///
/// Points always have three coordinates (a plane mesh has `z = 0`), so files, graphs and
/// fields need one design only.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimplexMesh<const V: usize> {
    /// Node positions, one row per node [length unit of the scene].
    pub points: Vec<[f64; 3]>,
    /// Node indices of each cell; a tetrahedron has positive volume, see [`crate::repair_orientation`].
    pub cells: Vec<[usize; V]>,
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
pub type TetMesh = SimplexMesh<4>;
/// Triangles.
pub type TriangleMesh = SimplexMesh<3>;

/// One side of a cell: the facet of `cell` that does not hold the cell's local vertex `opposite`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Facet {
    /// Index of the cell.
    pub cell: usize,
    /// Local index `0..V` of the vertex the facet leaves out.
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
