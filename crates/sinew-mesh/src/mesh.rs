//! The mesh itself: nodes, cells, named sets and fields.

use crate::Refusal;
use std::borrow::Cow;
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

/// Labels of a field; more are taken for numbering, unless each has several rows.
const MOST_LABELS: usize = 64;

/// Real numbers below this have no digits that were rounded off, 2⁵³.
const MOST_EXACT: f64 = 9_007_199_254_740_992.0;

/// Whether a number of distinct values in so many rows are labels.
pub(crate) fn are_labels(distinct: usize, rows: usize) -> bool {
    distinct <= MOST_LABELS || 4 * distinct <= rows
}

impl Field {
    /// A real number per row.
    pub fn scalars(values: Vec<f64>) -> Self {
        Field { components: 1, values: FieldValues::Float(values) }
    }

    /// `N` real numbers per row, such as a displacement with `N = 3`.
    pub fn vectors<const N: usize>(rows: &[[f64; N]]) -> Self {
        Field { components: N, values: FieldValues::Float(rows.as_flattened().to_vec()) }
    }

    /// An integer per row.
    pub fn labels(values: Vec<i64>) -> Self {
        Field { components: 1, values: FieldValues::Integer(values) }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.components.max(1)
    }

    /// All numbers, row by row; integers beyond 2⁵³ are rounded.
    pub fn to_f64(&self) -> Cow<'_, [f64]> {
        match &self.values {
            FieldValues::Float(values) => Cow::Borrowed(values),
            FieldValues::Integer(values) => values.iter().map(|&v| v as f64).collect(),
        }
    }

    /// The rows of a field with `N` components, or `None` when it has another number of them.
    pub fn to_vectors<const N: usize>(&self) -> Option<Vec<[f64; N]>> {
        let rows = self.to_f64();
        (self.components == N).then(|| rows.as_chunks::<N>().0.to_vec())
    }

    /// The rows with the given indices, in this order. Panics when one is out of range.
    pub fn select(&self, rows: &[usize]) -> Self {
        let width = self.components;
        let numbers = rows.iter().flat_map(|row| row * width..(row + 1) * width);
        Field { components: width, values: self.values.select(numbers) }
    }

    /// The field of nodes of which the first at a place has the row of another where its own is zero.
    pub(crate) fn joined(&self, first: &[usize]) -> Self {
        let (values, width) = (self.to_f64(), self.components);
        let is_zero = |row: usize| values[row * width..][..width].iter().all(|x| *x == 0.0);
        let mut source: Vec<usize> = (0..first.len()).collect();
        for (node, &first) in first.iter().enumerate() {
            if is_zero(source[first]) {
                source[first] = node;
            }
        }
        self.select(&source)
    }

    /// Whole numbers, one per row.
    pub(crate) fn to_labels(&self) -> Option<Cow<'_, [i64]>> {
        let is_label = |x: &f64| x.fract() == 0.0 && x.abs() < MOST_EXACT;
        match &self.values {
            FieldValues::Float(values) if self.components == 1 && values.iter().all(is_label) => {
                Some(values.iter().map(|&x| x as i64).collect())
            }
            _ => self.as_labels().map(Cow::Borrowed),
        }
    }

    pub(crate) fn as_labels(&self) -> Option<&[i64]> {
        match &self.values {
            FieldValues::Integer(values) if self.components == 1 => Some(values),
            _ => None,
        }
    }
}

impl FieldValues {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            FieldValues::Float(values) => values.len(),
            FieldValues::Integer(values) => values.len(),
        }
    }

    /// Whether the field has no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The numbers with the given indices, in this order. Panics when one is out of range.
    pub(crate) fn select(&self, indices: impl Iterator<Item = usize>) -> Self {
        match self {
            FieldValues::Float(all) => FieldValues::Float(indices.map(|i| all[i]).collect()),
            FieldValues::Integer(all) => FieldValues::Integer(indices.map(|i| all[i]).collect()),
        }
    }
}

impl<const N: usize> Mesh<N> {
    /// The nodes at which a scalar point field is not zero, ascending: the node set behind a
    /// marker such as `clamped`.
    ///
    /// # Errors
    /// When no scalar point field has this name, or its values are not finite.
    pub fn nodes_where_nonzero(&self, field: &str) -> Result<Vec<usize>, Refusal> {
        let is_scalar = |f: &&Field| f.components == 1;
        let found = self.point_fields.get(field).filter(is_scalar).ok_or_else(|| {
            let scalars = self.point_fields.iter().filter(|(_, f)| is_scalar(f));
            let names: Vec<&str> = scalars.map(|(name, _)| name.as_str()).collect();
            Refusal(format!(
                "there is no scalar point field `{}`, only: {}; choose one of these",
                field.escape_debug(),
                names.join(", ")
            ))
        })?;
        let numbers = found.to_f64();
        if let Some(row) = numbers.iter().position(|number| !number.is_finite()) {
            return Err(Refusal(format!(
                "field `{}` is {} at node {row}; give it a finite number, 0 where it marks nothing",
                field.escape_debug(),
                numbers[row]
            )));
        }
        Ok((0..numbers.len()).filter(|&node| numbers[node] != 0.0).collect())
    }
}
