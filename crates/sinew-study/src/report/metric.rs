//! The four error measures and the methods that are compared.

use serde::{Deserialize, Serialize};

/// An error measure of thesis (3.22).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// ‖u − û‖₂ per node \[mm\].
    ErrU,
    /// ‖F − F̂‖_F / ‖F‖_F per element \[%\].
    ErrF,
    /// |I₁ − Î₁| / I₁ per element \[%\].
    ErrI1,
    /// |Π − Π̂| / |Π| per test case \[%\].
    ErrPi,
}

impl Metric {
    /// All measures in the order of the thesis' tables.
    pub const ALL: [Self; 4] = [Self::ErrU, Self::ErrF, Self::ErrI1, Self::ErrPi];

    /// Field name in `report.json`.
    pub fn key(self) -> &'static str {
        match self {
            Self::ErrU => "err_u_mm",
            Self::ErrF => "err_F_pct",
            Self::ErrI1 => "err_I1_pct",
            Self::ErrPi => "err_Pi_pct",
        }
    }

    /// `mm` or `%`.
    pub fn unit(self) -> &'static str {
        match self {
            Self::ErrU => "mm",
            _ => "%",
        }
    }

    /// What one sample of the measure belongs to.
    pub fn sampled_per(self) -> &'static str {
        match self {
            Self::ErrU => "node",
            Self::ErrF | Self::ErrI1 => "element",
            Self::ErrPi => "test case",
        }
    }

    /// The quantity in words.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::ErrU => "displacement",
            Self::ErrF => "deformation gradient",
            Self::ErrI1 => "first invariant",
            Self::ErrPi => "potential energy",
        }
    }

    /// Subscript of the symbol: err_u, err_F, err_I₁, err_Π.
    pub(super) fn subscript(self) -> &'static str {
        match self {
            Self::ErrU => "u",
            Self::ErrF => "F",
            Self::ErrI1 => "I₁",
            Self::ErrPi => "Π",
        }
    }
}

/// One value for each error measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PerMetric<T> {
    /// For the nodal displacement error \[mm\].
    pub err_u_mm: T,
    /// For the error of the deformation gradient \[%\].
    #[serde(rename = "err_F_pct")]
    pub err_f_pct: T,
    /// For the error of the first invariant \[%\].
    #[serde(rename = "err_I1_pct")]
    pub err_i1_pct: T,
    /// For the error of the total potential energy \[%\].
    #[serde(rename = "err_Pi_pct")]
    pub err_pi_pct: T,
}

impl<T> PerMetric<T> {
    /// The value for one measure.
    pub fn get(&self, metric: Metric) -> &T {
        match metric {
            Metric::ErrU => &self.err_u_mm,
            Metric::ErrF => &self.err_f_pct,
            Metric::ErrI1 => &self.err_i1_pct,
            Metric::ErrPi => &self.err_pi_pct,
        }
    }

    /// Applies `f` to the value of every measure; the first error ends it.
    ///
    /// # Errors
    /// Those of `f`.
    pub fn try_map<U, E>(
        self,
        mut f: impl FnMut(Metric, T) -> Result<U, E>,
    ) -> Result<PerMetric<U>, E> {
        Ok(PerMetric {
            err_u_mm: f(Metric::ErrU, self.err_u_mm)?,
            err_f_pct: f(Metric::ErrF, self.err_f_pct)?,
            err_i1_pct: f(Metric::ErrI1, self.err_i1_pct)?,
            err_pi_pct: f(Metric::ErrPi, self.err_pi_pct)?,
        })
    }
}

/// A way to get the displacement for given parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Graph emulator fitted to simulated displacements (thesis 3.11).
    Dd,
    /// Graph emulator trained on the total potential energy (thesis 3.12).
    Pi,
    /// Graph emulator fitted to simulated displacements in the energy norm.
    Hybrid,
    /// Graph emulator fitted to displacements and deformation gradients (thesis B.1).
    Fdd,
    /// Proper orthogonal decomposition with regression of its coefficients.
    Pod,
    /// Finite-element solve from the undeformed state.
    FemCold,
    /// Finite-element solve from the solution at a neighbouring parameter.
    FemWarm,
}

impl Method {
    /// All methods in the order of tables and legends.
    pub const ALL: [Self; 7] =
        [Self::Dd, Self::Pi, Self::Hybrid, Self::Fdd, Self::Pod, Self::FemCold, Self::FemWarm];

    /// Name in `report.json` and `samples.csv`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Dd => "dd",
            Self::Pi => "pi",
            Self::Hybrid => "hybrid",
            Self::Fdd => "fdd",
            Self::Pod => "pod",
            Self::FemCold => "fem_cold",
            Self::FemWarm => "fem_warm",
        }
    }

    /// Name in tables and plots.
    pub fn label(self) -> &'static str {
        match self {
            Self::Dd => "DD-GNN",
            Self::Pi => "PI-GNN",
            Self::Hybrid => "hybrid GNN",
            Self::Fdd => "FDD-GNN",
            Self::Pod => "POD",
            Self::FemCold => "FEM cold",
            Self::FemWarm => "FEM warm",
        }
    }

    /// Whether the method approximates the finite-element solution (and is not one).
    pub fn is_emulator(self) -> bool {
        !matches!(self, Self::FemCold | Self::FemWarm)
    }
}
