//! The report: head, scenes, and what the thesis reached on them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Method, MethodRow, Metric, PerMetric, SurfaceCases, TrainingHistory};

/// Everything a study found out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Version of the file's schema, [`super::SCHEMA`].
    pub schema: u32,
    /// Command line that made the report.
    pub command: String,
    /// When the run ended, UTC, as [`super::utc_timestamp`] writes it.
    pub finished: String,
    /// Wall time of the whole run \[s\].
    pub wall_s: f64,
    /// Worker threads.
    pub threads: usize,
    /// Seed from which every random choice follows.
    pub seed: u64,
    /// Revision of the source.
    pub revision: String,
    /// Processor, cores and memory.
    pub machine: String,
    /// Versions of crates and compiler by name.
    pub versions: BTreeMap<String, String>,
    /// Configuration as it was used, in its own text format.
    pub config: String,
    /// What a reader has to know beside the numbers, e.g. a method that failed and why.
    pub notes: Vec<String>,
    /// The scenes in the order of the run.
    pub scenes: Vec<SceneReport>,
}

/// One scene with all methods that were run on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneReport {
    /// Name used on the command line and in file names, e.g. `once`.
    pub name: String,
    /// Name in the thesis, e.g. `OnceClampedBeam`.
    pub title: String,
    /// One line on geometry, law, load and supports.
    pub description: String,
    /// Units of length and stress, e.g. `mm, kPa`.
    pub units: String,
    /// Size of the mesh.
    pub mesh: MeshCounts,
    /// Parameters and their ranges, in the order of θ.
    pub theta: Vec<ThetaRange>,
    /// Parameters (and simulations, where a method uses them) for training.
    pub train_samples: usize,
    /// Test cases behind every error.
    pub test_samples: usize,
    /// Size of the displacements over the test set.
    pub displacement: DisplacementScale,
    /// What the thesis reports for this scene.
    pub thesis: Option<ThesisReference>,
    /// Errors and times, one row per method.
    pub methods: Vec<MethodRow>,
    /// Curves of the methods that were trained step by step.
    pub training: Vec<TrainingHistory>,
    /// Deformed surfaces coloured by error.
    pub surfaces: Option<SurfaceCases>,
}

impl SceneReport {
    /// The row of a method, if it was run.
    pub fn row(&self, method: Method) -> Option<&MethodRow> {
        self.methods.iter().find(|row| row.method() == method)
    }

    /// Rows in the order of [`Method::ALL`].
    pub(super) fn ordered_rows(&self) -> Vec<&MethodRow> {
        let mut rows: Vec<_> = self.methods.iter().collect();
        rows.sort_by_key(|row| row.method());
        rows
    }
}

/// Size of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshCounts {
    /// Nodes.
    pub nodes: usize,
    /// Elements.
    pub elements: usize,
    /// Displacement components that are not prescribed.
    pub unknowns: usize,
}

/// Range of one parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ThetaRange {
    /// Symbol, e.g. `μ`.
    pub name: String,
    /// Unit, e.g. `kPa`; empty if it has none.
    pub unit: String,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

/// Size of displacements over all nodes and test cases.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DisplacementScale {
    /// Mean of ‖u‖ \[mm\].
    pub mean_mm: f64,
    /// Largest ‖u‖ \[mm\].
    pub max_mm: f64,
}

/// Median errors printed in the thesis, where it prints them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ThesisReference {
    /// Data-driven emulator.
    pub dd: PerMetric<Option<f64>>,
    /// Physics-informed emulator.
    pub pi: PerMetric<Option<f64>>,
    /// Size of the displacements.
    pub displacement: Option<DisplacementScale>,
}

impl ThesisReference {
    /// Median of a method, if the thesis has it; of the better of its two methods for the hybrid, which it has not.
    pub fn median(&self, method: Method, metric: Metric) -> Option<f64> {
        let (dd, pi) = (*self.dd.get(metric), *self.pi.get(metric));
        match method {
            Method::Dd => dd,
            Method::Pi => pi,
            Method::Hybrid => dd.zip(pi).map(|(dd, pi)| dd.min(pi)),
            _ => None,
        }
    }
}
