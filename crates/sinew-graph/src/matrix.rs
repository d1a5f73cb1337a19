//! Tables of numbers on nodes and edges.

use crate::error::GraphError;
use serde::{Deserialize, Serialize};

/// A table of numbers, row by row: one row per node or per edge.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FeatureMatrix {
    /// Rows: nodes or edges.
    pub rows: usize,
    /// Numbers per row.
    pub columns: usize,
    /// The numbers, `rows × columns`, row by row.
    pub values: Vec<f64>,
}

impl FeatureMatrix {
    /// One column that is 1 on the nodes of a set and 0 elsewhere, such as the indicator of
    /// the Dirichlet boundary (thesis §2.3.2).
    ///
    /// # Errors
    /// When the set names a node that does not exist.
    pub fn indicator(nodes: usize, set: &[usize]) -> Result<Self, GraphError> {
        let mut values = vec![0.0; nodes];
        for &node in set {
            ensure!(
                node < nodes,
                "node {node} of the set does not exist, there are {nodes} nodes, counted from 0"
            );
            values[node] = 1.0;
        }
        Ok(Self { rows: nodes, columns: 1, values })
    }

    /// `N` columns from one array per node, such as a fibre direction.
    pub fn from_rows<const N: usize>(rows: &[[f64; N]]) -> Self {
        Self { rows: rows.len(), columns: N, values: rows.as_flattened().to_vec() }
    }

    /// Puts the columns of `other` to the right of these.
    ///
    /// # Errors
    /// When the rows differ in number, or values do not fill a table.
    pub fn hstack(&self, other: &Self) -> Result<Self, GraphError> {
        self.check("left columns", self.rows)?;
        other.check("right columns", self.rows)?;
        let columns = self.columns + other.columns;
        let values = (0..self.rows).flat_map(|r| self.row(r).iter().chain(other.row(r)).copied());
        Ok(Self { rows: self.rows, columns, values: values.collect() })
    }

    /// One row.
    ///
    /// # Panics
    /// When there is no such row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.columns..(row + 1) * self.columns]
    }

    /// Size as needed and every value finite.
    pub(crate) fn check(&self, what: &'static str, rows: usize) -> Result<(), GraphError> {
        ensure!(
            self.rows == rows,
            "{what}: {rows} rows needed, {} given: use the mesh the graph was built of",
            self.rows
        );
        let (columns, values) = (self.columns, self.values.len());
        ensure!(
            self.rows.checked_mul(columns) == Some(values),
            "a table of {rows} rows and {columns} columns cannot hold {values} values"
        );
        for (at, value) in self.values.iter().enumerate() {
            ensure!(
                value.is_finite(),
                "{what}: row {}, column {} is {value}: features must be finite",
                at / columns,
                at % columns
            );
        }
        Ok(())
    }
}
