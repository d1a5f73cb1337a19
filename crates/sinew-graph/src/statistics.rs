//! Standardisation of features.

use crate::{FeatureMatrix, GraphError, GraphFeatures};
use serde::{Deserialize, Serialize};

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
