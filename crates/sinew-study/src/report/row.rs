//! One method with its errors and its times.

use serde::{Deserialize, Serialize};

use super::error::check_number;
use super::{LogHistogram, Method, Metric, PerMetric, Quantiles, ReportError, quantiles};

/// Quantiles of every error measure over the whole test set.
pub type Errors = PerMetric<Quantiles>;
/// Distribution of every error measure over the whole test set.
pub type Histograms = PerMetric<LogHistogram>;
/// Error samples: per node and case, per element and case (twice), per case.
pub type ErrorSamples = PerMetric<Vec<f64>>;

/// What a method costs on the machine of the report. All times are wall time \[s\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Field names and values of all times \[s\].
    pub fn entries(&self) -> [(&'static str, f64); 5] {
        [
            ("prepare_s", self.prepare_s),
            ("train_s", self.train_s),
            ("predict_full_s", self.predict_full_s),
            ("predict_decoder_s", self.predict_decoder_s),
            ("predict_batch_per_theta_s", self.predict_batch_per_theta_s),
        ]
    }
}

/// A method, what it is, what its error is measured against, errors and times.
///
/// Exists only with all numbers finite and not negative, also when read from a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "UncheckedRow")]
pub struct MethodRow {
    method: Method,
    description: String,
    reference: String,
    errors: Errors,
    times: Times,
    histograms: Histograms,
}

#[derive(Deserialize)]
struct UncheckedRow {
    method: Method,
    description: String,
    reference: String,
    errors: Errors,
    times: Times,
    histograms: Histograms,
}

impl TryFrom<UncheckedRow> for MethodRow {
    type Error = ReportError;

    fn try_from(row: UncheckedRow) -> Result<Self, ReportError> {
        Self::new(row.method, row.description, row.reference, row.errors, row.histograms, row.times)
    }
}

impl MethodRow {
    /// A row from summarised errors.
    ///
    /// `description` says in one line what the method does; `reference` says what its
    /// error is measured against: the finite-element solution for an emulator, an
    /// independent solution for the finite-element solver itself.
    ///
    /// # Errors
    /// [`ReportError::Number`] if an error or a time is NaN, infinite or negative,
    /// [`ReportError::EmptyText`] if a text is empty; both name the field.
    pub fn new(
        method: Method,
        description: impl Into<String>,
        reference: impl Into<String>,
        errors: Errors,
        histograms: Histograms,
        times: Times,
    ) -> Result<Self, ReportError> {
        let row = Self {
            method,
            description: description.into(),
            reference: reference.into(),
            errors,
            times,
            histograms,
        };
        row.check()?;
        Ok(row)
    }

    /// A row from all error samples of the test set.
    ///
    /// # Errors
    /// As [`MethodRow::new`]; [`ReportError::NoSamples`] and [`ReportError::Sample`] if
    /// a measure has no samples or one that is NaN, infinite or negative.
    pub fn from_samples(
        method: Method,
        description: impl Into<String>,
        reference: impl Into<String>,
        samples: ErrorSamples,
        times: Times,
    ) -> Result<Self, ReportError> {
        let summarised = samples.try_map(|metric, mut values| {
            let field = metric.key();
            let invalid = |value: &f64| !(value.is_finite() && *value >= 0.0);
            if let Some(index) = values.iter().position(invalid) {
                let value = values[index];
                return Err(ReportError::Sample { field, index, value });
            }
            let histogram = LogHistogram::from_samples(&values);
            let quantiles = quantiles(&mut values).ok_or(ReportError::NoSamples { field })?;
            Ok((quantiles, histogram))
        })?;
        let errors = summarised.clone().try_map(|_, (q, _)| Ok::<_, ReportError>(q))?;
        let histograms = summarised.try_map(|_, (_, h)| Ok::<_, ReportError>(h))?;
        Self::new(method, description, reference, errors, histograms, times)
    }

    fn check(&self) -> Result<(), ReportError> {
        let key = self.method.key();
        for (field, text) in [("description", &self.description), ("reference", &self.reference)] {
            if text.trim().is_empty() {
                let field = format!("{key}.{field}");
                return Err(ReportError::EmptyText { field });
            }
        }
        for metric in Metric::ALL {
            for (name, value) in self.errors.get(metric).entries() {
                check_number(|| format!("{key}.errors.{}.{name}", metric.key()), value)?;
            }
        }
        for (name, value) in self.times.entries() {
            check_number(|| format!("{key}.times.{name}"), value)?;
        }
        Ok(())
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// What the method does, in one line.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// What the error is measured against.
    pub fn reference(&self) -> &str {
        &self.reference
    }

    /// Quantiles of the errors over the test set.
    pub fn errors(&self) -> &Errors {
        &self.errors
    }

    /// Distributions of the errors over the test set.
    pub fn histograms(&self) -> &Histograms {
        &self.histograms
    }

    /// What the method costs.
    pub fn times(&self) -> &Times {
        &self.times
    }

    /// Median of one error measure, in its unit.
    pub fn median(&self, metric: Metric) -> f64 {
        self.errors.get(metric).q50
    }
}
