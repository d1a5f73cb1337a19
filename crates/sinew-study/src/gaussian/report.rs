//! The result of `reproduce-gp` as data: `report.json`.

use crate::gaussian::picture::Figure;
use crate::gaussian::row::Row;
use crate::report::ReportError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Version of the file, raised with any change of its fields.
pub const SCHEMA: u32 = 1;

/// All experiments of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GaussianReport {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Command line of the run.
    pub command: String,
    /// End of the run, `2026-03-01 14:05:09 UTC`.
    pub finished: String,
    /// Wall time of the whole run \[s\].
    pub wall_s: f64,
    /// Fits side by side, each on one thread.
    pub threads: usize,
    /// Seed that all seeds derive from.
    pub seed: u64,
    /// Data sets behind every median.
    pub data_sets: usize,
    /// Revision of the source.
    pub revision: String,
    /// Processor and operating system.
    pub machine: String,
    /// Version of each package that numbers depend on.
    pub versions: BTreeMap<String, String>,
    /// Options as used.
    pub config: String,
    /// What has to be known beside the numbers.
    pub notes: Vec<String>,
    /// The experiments.
    pub experiments: Vec<ExperimentReport>,
}

/// One experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExperimentReport {
    /// Name on the command line.
    pub name: String,
    /// Title, with the thesis' section.
    pub title: String,
    /// What is done.
    pub about: String,
    /// One row per method and setting.
    pub rows: Vec<Row>,
    /// Drawings.
    pub figures: Vec<Figure>,
}

/// Reads `report.json`.
///
/// # Errors
/// [`ReportError::Schema`] for another version, [`ReportError::Json`] for anything that is no report,
/// [`ReportError::Io`] if the file cannot be read.
pub fn read_json(path: &Path) -> Result<GaussianReport, ReportError> {
    #[derive(Deserialize)]
    struct Version {
        schema: u64,
    }
    let text = fs::read_to_string(path).map_err(|source| ReportError::io(path, source))?;
    let found = serde_json::from_str::<Version>(&text)?.schema;
    if found != u64::from(SCHEMA) {
        return Err(ReportError::Schema { found, expected: SCHEMA });
    }
    Ok(serde_json::from_str(&text)?)
}
