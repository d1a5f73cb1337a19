//! What one method contributes to the report.

use crate::report::{self, ErrorSamples, MethodRow, SampleRow, Spread, Times};
use anyhow::{Context, Result};
use sinew_emulate::{CaseErrors, CurvePoint, TestSet, median_and_worst};

/// What one method contributes to the report.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    pub(crate) row: MethodRow,
    pub(crate) samples: Vec<SampleRow>,
    /// Errors on the held-out cases while an emulator was trained; empty for methods without steps.
    pub(crate) history: Vec<CurvePoint>,
    pub(crate) median_and_worst: [usize; 2],
    /// Reasons not to trust the method's errors to be what it can do.
    pub(crate) concerns: Vec<String>,
    pub(crate) predictions: Vec<Vec<f64>>,
}

impl Outcome {
    /// Of the displacements that a method gives for the cases of a test set.
    pub(crate) fn new(
        method: report::Method,
        description: &str,
        test: &TestSet<'_>,
        times: Times,
        predictions: Vec<Vec<f64>>,
    ) -> Result<Self> {
        let reference = match method {
            report::Method::FemCold | report::Method::FemWarm => {
                "FEniCS on the same mesh (fixtures/beam)"
            }
            _ => "our finite-element solution on the same mesh",
        };
        let cases = test.cases(&predictions)?;
        Ok(Self {
            row: MethodRow::from_samples(method, description, reference, samples(&cases), times)?,
            samples: rows(method, test, &cases)?,
            history: Vec::new(),
            median_and_worst: median_and_worst(&cases),
            concerns: Vec::new(),
            predictions,
        })
    }
}

/// All errors: per free node and case, per element and case, per case.
fn samples(cases: &[CaseErrors]) -> ErrorSamples {
    let gather = |of: fn(&CaseErrors) -> &[f64]| {
        cases.iter().flat_map(|case| of(case).iter().copied()).collect()
    };
    ErrorSamples {
        err_u_mm: gather(|case| &case.err_u),
        err_f_pct: gather(|case| &case.err_f),
        err_i1_pct: gather(|case| &case.err_i1),
        err_pi_pct: gather(|case| std::slice::from_ref(&case.err_pi)),
    }
}

/// One line per case for the table of samples.
fn rows(
    method: report::Method,
    test: &TestSet<'_>,
    cases: &[CaseErrors],
) -> Result<Vec<SampleRow>> {
    let spread = |values: &[f64]| {
        Spread::of(values.to_vec()).context("an error of a test case is not a number")
    };
    let row = |(sample, (case, theta)): (usize, (&CaseErrors, &Vec<f64>))| {
        Ok(SampleRow {
            sample,
            method,
            theta: theta.clone(),
            err_u_mm: spread(&case.err_u)?,
            err_f_pct: spread(&case.err_f)?,
            err_i1_pct: spread(&case.err_i1)?,
            err_pi_pct: case.err_pi,
        })
    };
    cases.iter().zip(&test.thetas).enumerate().map(row).collect()
}
