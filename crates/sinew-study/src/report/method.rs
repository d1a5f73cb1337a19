//! The methods that are compared, and what the thesis prints of them.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// A way to get the displacement for given parameters; those that train a network can be chosen.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, ValueEnum, Serialize, Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// On simulated displacements, thesis (3.11)
    Dd,
    /// By minimum potential energy, without any simulation, thesis (3.12)
    Pi,
    /// On simulated displacements, errors weighed by the body's stiffness
    Hybrid,
    /// On simulated displacements and deformation gradients, thesis (B.1)
    Fdd,
    /// Proper orthogonal decomposition with regression of its coefficients
    #[value(skip)]
    Pod,
    /// Finite-element solve from the undeformed state
    #[value(skip)]
    FemCold,
    /// Finite-element solve from the solution at a neighbouring parameter
    #[value(skip)]
    FemWarm,
}

impl Method {
    /// All methods in the order of tables and legends.
    pub const ALL: [Self; 7] =
        [Self::Dd, Self::Pi, Self::Hybrid, Self::Fdd, Self::Pod, Self::FemCold, Self::FemWarm];

    /// Name in files and in `samples.csv`.
    pub fn key(self) -> &'static str {
        ["dd", "pi", "hybrid", "fdd", "pod", "fem_cold", "fem_warm"][self as usize]
    }

    /// Name in tables and plots.
    pub fn label(self) -> &'static str {
        ["DD-GNN", "PI-GNN", "hybrid GNN", "FDD-GNN", "POD", "FEM cold", "FEM warm"][self as usize]
    }

    /// Whether it is the solver itself.
    pub(crate) fn is_solver(self) -> bool {
        matches!(self, Self::FemCold | Self::FemWarm)
    }
}

/// Median errors printed in the thesis, in the order of [`sinew_emulate::METRICS`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThesisReference {
    /// Data-driven emulator.
    pub dd: [f64; 4],
    /// Physics-informed emulator.
    pub pi: [f64; 4],
    /// Mean and largest displacement \[mm\].
    pub displacement_mm: [f64; 2],
}

impl ThesisReference {
    /// Median of a method, if the thesis has it; of the better of its two methods for the hybrid, which it has not.
    pub(crate) fn median(&self, method: Method, metric: usize) -> Option<f64> {
        let (dd, pi) = (self.dd[metric], self.pi[metric]);
        match method {
            Method::Dd => Some(dd),
            Method::Pi => Some(pi),
            Method::Hybrid => Some(dd.min(pi)),
            _ => None,
        }
    }
}
