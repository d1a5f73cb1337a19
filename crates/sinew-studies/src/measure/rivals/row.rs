//! A row of the table: one program on one mesh.

use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Row {
    pub elements: String,
    pub nodes: usize,
    pub cells: usize,
    pub program: String,
    #[serde(flatten)]
    pub outcome: Outcome,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(untagged)]
pub(super) enum Outcome {
    Solved(Solved),
    /// Why there is none, and how the program is installed.
    Missing {
        missing: String,
    },
}

/// Smaller times of two solves; seconds of the CPU.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Solved {
    pub version: String,
    /// Linear solver.
    pub solver: String,
    pub import_s: f64,
    pub compile_s: f64,
    /// Mesh, spaces and unknowns.
    pub setup_s: f64,
    pub solve_s: f64,
    /// Part of it that assembles stiffnesses, where the program tells.
    pub assembly_s: Option<f64>,
    pub load_steps: usize,
    /// Newton's method.
    pub iterations: usize,
    pub linear_iterations: usize,
    pub energy: f64,
    /// Difference of energies from Sinew's \[relative\].
    #[serde(default)]
    pub energy_apart: f64,
    /// Displacement of the apex of the endocardium \[mm\].
    pub apex: [f64; 3],
    /// Largest distance of a displacement from Sinew's \[relative to the largest\].
    pub apart: f64,
    pub peak_gb: f64,
}

/// Row of Sinew with the size of the mesh that it made.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Own {
    pub nodes: usize,
    pub cells: usize,
    #[serde(flatten)]
    pub solved: Solved,
}

impl Outcome {
    /// Outcome with the difference of its energy from Sinew's.
    pub(super) fn beside(self, truth: f64) -> Self {
        match self {
            Self::Solved(solved) => {
                Self::Solved(Solved { energy_apart: solved.energy / truth - 1.0, ..solved })
            }
            missing @ Self::Missing { .. } => missing,
        }
    }

    pub(super) fn in_words(&self) -> String {
        match self {
            Self::Solved(solved) => format!(
                "{:.2} and {:.2} CPU s, {} iterations, energy {:.14e}",
                solved.setup_s, solved.solve_s, solved.iterations, solved.energy
            ),
            Self::Missing { missing } => missing.clone(),
        }
    }
}
