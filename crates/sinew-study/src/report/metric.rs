//! The four error measures and the methods that are compared.

use serde::{Deserialize, Serialize};
use sinew_report::{Cell, Column, Distribution, ReportError, Row};

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

    /// Name, unit and definition.
    pub fn column(self) -> Column {
        let (name, about) = match self {
            Self::ErrU => (
                "err_u",
                "‖u − û‖₂ at every node that is free [mm]; u is the reference, û the prediction",
            ),
            Self::ErrF => ("err_F", "‖F − F̂‖_F / ‖F‖_F in every element [%]"),
            Self::ErrI1 => ("err_I₁", "|I₁ − Î₁| / I₁ in every element [%]"),
            Self::ErrPi => ("err_Π", "|Π − Π̂| / |Π| of every test case [%]"),
        };
        Column::new(name, self.unit()).about(about)
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
}

/// Error samples: per free node and case, per element and case (twice), per case.
pub type ErrorSamples = PerMetric<Vec<f64>>;

/// What a method costs on the machine of the report. All times are wall time \[s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// Before training: simulations, graph, bases. Zero for a solver.
    pub prepare_s: f64,
    /// Training or regression. Zero for a solver.
    pub train_s: f64,
    /// Optimiser steps. Zero without an iterative training.
    pub steps: u64,
    /// One prediction with nothing precomputed but what `prepare_s` and `train_s` paid for.
    pub predict_full_s: f64,
    /// One prediction for a geometry seen before; equals `predict_full_s` for a solver.
    pub predict_decoder_s: f64,
    /// Time per parameter when many are predicted at once.
    pub predict_batch_per_theta_s: f64,
}

impl Times {
    /// Heads of the times in a table.
    pub fn columns() -> [Column; 5] {
        let column = |name: &str, about: &str| Column::new(name, "").about(about);
        [
            column(
                "prepare",
                "everything before training: simulations for training data, graph, basis",
            )
            .once(),
            column("train", "training or regression, without the evaluations that make the curves")
                .once(),
            column(
                "full",
                "one prediction from mesh and θ (emulators: message passing and decoder)",
            ),
            column(
                "decoder",
                "one prediction on a geometry whose part is computed already; a solver repeats full",
            ),
            column("in a batch", "time per θ when many are predicted at once"),
        ]
    }
}

/// A row of the report, and whose it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodRow {
    method: Method,
    /// Errors in the order of [`Metric::ALL`], times in that of [`Times::columns`].
    pub row: Row,
}

impl MethodRow {
    /// A row from all error samples of the test set. `description` says in one line what the method does, `reference`
    /// what its error is measured against.
    ///
    /// # Errors
    /// [`ReportError`] if a measure has no samples, or one or a time is NaN, infinite or negative.
    pub fn from_samples(
        method: Method,
        description: &str,
        reference: &str,
        samples: ErrorSamples,
        times: Times,
    ) -> Result<Self, ReportError> {
        let name = |metric: Metric| format!("{} of {}", metric.key(), method.key());
        let errors =
            samples.try_map(|metric, values| Distribution::with_density(&name(metric), values))?;
        let row = Row::new(method.label(), errors.err_u_mm, times.prepare_s)?
            .described(description, reference)
            .error(errors.err_f_pct)
            .error(errors.err_i1_pct)
            .error(errors.err_pi_pct)
            .time(times.train_s)
            .time(times.predict_full_s)
            .time(times.predict_decoder_s)
            .time(times.predict_batch_per_theta_s)
            .other((times.steps > 0).then_some(times.steps as f64));
        Ok(Self { method, row })
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The row beside what the thesis prints.
    pub fn against(&self, thesis: &ThesisReference) -> Row {
        let mut row = self.row.clone();
        for (cell, metric) in row.errors.iter_mut().zip(Metric::ALL) {
            *cell = Cell::against(
                std::mem::take(cell),
                "the thesis’",
                thesis.median(self.method, metric),
            );
        }
        row
    }
}

/// Median errors printed in the thesis, where it prints them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ThesisReference {
    /// Data-driven emulator.
    pub dd: PerMetric<Option<f64>>,
    /// Physics-informed emulator.
    pub pi: PerMetric<Option<f64>>,
    /// Mean and largest displacement \[mm\].
    pub displacement_mm: [f64; 2],
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
