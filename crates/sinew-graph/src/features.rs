//! Numbers on nodes and edges, and their standardisation.

use crate::{GraphError, Topology, pool_features, pool_positions, positions::range};
use serde::{Deserialize, Serialize};

/// The features of one geometry on a [`Topology`], raw or standardised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraphFeatures {
    /// One row per node, virtual ones included.
    pub nodes: FeatureMatrix,
    /// One row per stored edge, in the order of [`Topology::senders`].
    pub edges: FeatureMatrix,
}

/// Features of one geometry: the caller's columns pooled to the virtual nodes, and
/// `(x_j − x_i, ‖x_j − x_i‖)` on the edge from sender `i` to receiver `j` (thesis Eq. 2.23).
///
/// * `positions` — mesh node positions [length unit of the scene].
/// * `node_columns` — any numbers per mesh node but no absolute positions, which would end
///   the emulator's invariance to translations.
/// * `dimensions` — coordinates that enter: 2 for a plane mesh, 3 in space.
///
/// # Errors
/// When a table does not belong to the topology, a number is not finite, or a coordinate left
/// out is not constant.
pub fn graph_features(
    topology: &Topology,
    positions: &[[f64; 3]],
    node_columns: &FeatureMatrix,
    dimensions: usize,
) -> Result<GraphFeatures, GraphError> {
    let nodes = pool_features(topology, node_columns)?;
    let positions = pool_positions(topology, positions)?;
    check_dimensions(&positions[..topology.real_nodes], dimensions)?;
    let (rows, columns) = (topology.senders.len(), dimensions + 1);
    let mut values = Vec::with_capacity(rows * columns);
    for [sender, receiver] in topology.edges() {
        let (from, to) = (positions[sender], positions[receiver]);
        let step: [f64; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
        values.extend_from_slice(&step[..dimensions]);
        values.push(step[..dimensions].iter().fold(0.0, |length: f64, s| length.hypot(*s)));
    }
    let edges = FeatureMatrix { rows, columns, values };
    edges.check("edge features", rows)?;
    Ok(GraphFeatures { nodes, edges })
}

/// The first `dimensions` coordinates must tell the whole shape.
fn check_dimensions(positions: &[[f64; 3]], dimensions: usize) -> Result<(), GraphError> {
    ensure!(
        (1..=3).contains(&dimensions),
        "{dimensions} space dimensions were asked for: use 1, 2 or 3"
    );
    for axis in dimensions..3 {
        let [lowest, highest] = range(positions, axis);
        ensure!(
            lowest == highest,
            "coordinate {axis} runs from {lowest} to {highest}, but only {dimensions} dimensions enter the edge features: use {}",
            axis + 1
        );
    }
    Ok(())
}

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

/// Mean and scale of each column of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ColumnStatistics {
    /// Mean of each column.
    pub mean: Vec<f64>,
    /// Population standard deviation of each column; 1 for a constant column, which then
    /// standardises to zeros.
    #[serde(alias = "deviation")]
    pub scale: Vec<f64>,
}

/// Statistics of node and edge features over a set of geometries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeatureStatistics {
    /// Statistics over all nodes, virtual ones included, of all geometries.
    pub nodes: ColumnStatistics,
    /// Statistics over all stored edges of all geometries.
    pub edges: ColumnStatistics,
}

impl FeatureStatistics {
    /// Spread below which a column counts as constant, relative to its largest magnitude:
    /// rounding of a mean leaves a few 1e-16, no feature of interest varies by 1e-12.
    pub(crate) const CONSTANT: f64 = 1e-12;

    /// Statistics over the training geometries.
    ///
    /// # Errors
    /// When there is no geometry, their columns differ, or a number is not finite.
    pub fn over(geometries: &[GraphFeatures]) -> Result<Self, GraphError> {
        let tables = |pick: fn(&GraphFeatures) -> &FeatureMatrix| geometries.iter().map(pick);
        Ok(Self {
            nodes: ColumnStatistics::over("node features", tables(|g| &g.nodes))?,
            edges: ColumnStatistics::over("edge features", tables(|g| &g.edges))?,
        })
    }

    /// `(value − mean) / scale` for every column.
    ///
    /// # Errors
    /// When the columns differ in number or a value is not finite.
    pub fn standardise(&self, features: &GraphFeatures) -> Result<GraphFeatures, GraphError> {
        Ok(GraphFeatures {
            nodes: self.nodes.standardise("node features", &features.nodes)?,
            edges: self.edges.standardise("edge features", &features.edges)?,
        })
    }
}

impl ColumnStatistics {
    /// Statistics over the rows of all tables; `what` they are goes into messages.
    ///
    /// # Errors
    /// As [`FeatureStatistics::over`].
    pub fn over<'a>(
        what: &'static str,
        tables: impl Iterator<Item = &'a FeatureMatrix> + Clone,
    ) -> Result<Self, GraphError> {
        let columns = tables
            .clone()
            .next()
            .ok_or_else(|| GraphError("no geometry was given: at least 1 is needed".into()))?
            .columns;
        for table in tables.clone() {
            table.check(what, table.rows)?;
            same_columns(what, columns, table.columns)?;
        }
        let column = |c: usize| {
            let tables = tables.clone();
            tables.flat_map(move |t| t.values.iter().skip(c).step_by(columns).copied())
        };
        let (mean, scale) = (0..columns).map(|c| mean_and_scale(column(c))).unzip();
        Ok(Self { mean, scale })
    }

    /// `(value − mean) / scale` for every column.
    ///
    /// # Errors
    /// As [`FeatureStatistics::standardise`].
    pub fn standardise(
        &self,
        what: &'static str,
        table: &FeatureMatrix,
    ) -> Result<FeatureMatrix, GraphError> {
        table.check(what, table.rows)?;
        same_columns(what, self.mean.len(), self.scale.len())?;
        same_columns(what, self.mean.len(), table.columns)?;
        let mut standardised = table.clone();
        for (at, value) in standardised.values.iter_mut().enumerate() {
            let column = at % table.columns;
            *value = (*value - self.mean[column]) / self.scale[column];
        }
        standardised.check(what, table.rows)?;
        Ok(standardised)
    }
}

fn same_columns(what: &str, expected: usize, found: usize) -> Result<(), GraphError> {
    ensure!(
        expected == found,
        "{what}: {expected} columns needed, {found} given: all geometries and their statistics must use the same features"
    );
    Ok(())
}

/// Two passes, the first relative to the first value: exact for a constant column.
fn mean_and_scale(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let Some(origin) = values.clone().next() else { return (0.0, 1.0) };
    let count = values.clone().count() as f64;
    let mean = origin + values.clone().map(|v| v - origin).sum::<f64>() / count;
    let largest = values.clone().map(f64::abs).fold(0.0, f64::max);
    // A power of two, which changes no digit: squares of the numbers themselves may overflow or vanish.
    let unit = f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits()).max(f64::MIN_POSITIVE);
    let variance = values.map(|v| ((v - mean) / unit).powi(2)).sum::<f64>() / count;
    let deviation = unit * variance.sqrt();
    let scale = if deviation <= FeatureStatistics::CONSTANT * largest { 1.0 } else { deviation };
    (mean, scale)
}
