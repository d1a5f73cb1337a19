//! What one method contributes to the report.

use crate::report::Method;
use anyhow::Result;
use sinew_emulate::{CaseErrors, CurvePoint, METRICS, TestSet, median_and_worst};
use sinew_report::{Cell, Column, Distribution, ReportError, Row};

/// What one method contributes to the report.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    pub(crate) method: Method,
    /// Errors in the order of [`METRICS`], times in that of [`time_columns`], then the steps.
    pub(crate) row: Row,
    /// Parameters of the test cases.
    pub(crate) thetas: Vec<Vec<f64>>,
    pub(crate) cases: Vec<CaseErrors>,
    /// Errors on the held-out cases while an emulator was trained; empty for methods without steps.
    pub(crate) history: Vec<CurvePoint>,
    pub(crate) median_and_worst: [usize; 2],
    /// Reasons not to trust the method's errors to be what it can do.
    pub(crate) concerns: Vec<String>,
    pub(crate) predictions: Vec<Vec<f64>>,
}

/// Heads of the times in a table: wall time on the machine of the report.
pub(crate) fn time_columns() -> [Column; 5] {
    let column = |name: &str, about: &str| Column::new(name, "").about(about);
    [
        column(
            "prepare",
            "everything before training: simulations for training data, graph, basis",
        )
        .once(),
        column("train", "training or regression, without the evaluations that make the curves")
            .once(),
        column("full", "one prediction from mesh and θ (emulators: message passing and decoder)"),
        column(
            "decoder",
            "one prediction on a geometry whose part is computed already; a solver repeats full",
        ),
        column("in a batch", "time per θ when many are predicted at once"),
    ]
}

impl Outcome {
    /// Of the displacements that a method gives for the cases of a test set, with its times \[s\].
    pub(crate) fn new(
        method: Method,
        description: &str,
        test: &TestSet<'_>,
        times: [f64; 5],
        predictions: Vec<Vec<f64>>,
    ) -> Result<Self> {
        let reference = match method.is_solver() {
            true => "FEniCS on the same mesh (fixtures/beam)",
            false => "our finite-element solution on the same mesh",
        };
        let cases = test.cases(&predictions)?;
        let errors = METRICS.iter().map(|metric| {
            let name = format!("{} of {}", metric.name, method.key());
            Ok(Distribution::with_density(&name, metric.pooled(&cases).collect())?.into())
        });
        let errors: Vec<Cell> = errors.collect::<Result<_, ReportError>>()?;
        let row = Row::new(method.label(), errors[0].clone(), times[0])?
            .described(description, reference);
        Ok(Self {
            method,
            row: Row { errors, times: times.map(Cell::from).to_vec(), ..row },
            thetas: test.thetas.clone(),
            history: Vec::new(),
            median_and_worst: median_and_worst(&cases),
            cases,
            concerns: Vec::new(),
            predictions,
        })
    }
}
