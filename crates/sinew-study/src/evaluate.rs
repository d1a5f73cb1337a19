//! Errors of a method over a test set, thesis (3.22).

use crate::report::{ErrorSamples, Method, PerMetric, SampleRow, Spread, quantiles};
use anyhow::{Context, Result, ensure};
use rayon::prelude::*;
use sinew_energy::metrics;

/// Test cases with their true displacements and energies.
#[derive(Clone, Debug)]
pub struct TestSet {
    /// Potential whose guard keeps the energy of a bad prediction finite; a guard is the identity
    /// at every admissible state.
    pub potential: sinew_energy::Body,
    /// Parameters, case by case.
    pub thetas: Vec<Vec<f64>>,
    /// True displacements, case by case \[mm\].
    pub displacements: Vec<Vec<f64>>,
}

/// Errors of one case.
#[derive(Clone, Debug)]
struct CaseErrors {
    /// Per free node \[mm\].
    err_u: Vec<f64>,
    /// Per element [%].
    err_f: Vec<f64>,
    /// Per element [%].
    err_i1: Vec<f64>,
    /// Of the total potential [%].
    err_pi: f64,
}

/// Errors of one method over a test set.
#[derive(Clone, Debug)]
pub struct Evaluation {
    cases: Vec<CaseErrors>,
    thetas: Vec<Vec<f64>>,
}

impl TestSet {
    /// Errors of `predictions`, one displacement per case, in the same order.
    ///
    /// Displacement errors are taken over the nodes that some support leaves free: clamped ones are
    /// exact for every method and would flatter the medians.
    ///
    /// # Errors
    /// A prediction of the wrong length, or one that is not finite.
    pub fn evaluate(&self, predictions: &[Vec<f64>]) -> Result<Evaluation> {
        ensure!(
            predictions.len() == self.thetas.len(),
            "{} predictions for {} test cases",
            predictions.len(),
            self.thetas.len()
        );
        let free = self.free_nodes();
        let cases = (0..self.thetas.len())
            .into_par_iter()
            .map(|case| self.case(case, &predictions[case], &free))
            .collect::<Result<_>>()?;
        Ok(Evaluation { cases, thetas: self.thetas.clone() })
    }

    /// Mean of the energy above the minimum, relative to it [%].
    pub fn mean_energy_excess(&self, predictions: &[Vec<f64>]) -> f64 {
        let excess = |case: usize| {
            let value = |u: &[f64]| self.potential.value(u, &self.thetas[case]);
            let truth = value(&self.displacements[case]);
            100.0 * (value(&predictions[case]) - truth) / truth.abs()
        };
        let count = self.thetas.len();
        (0..count).map(excess).sum::<f64>() / count as f64
    }

    fn free_nodes(&self) -> Vec<usize> {
        let rows = self.potential.prescribed.chunks_exact(3).enumerate();
        rows.filter(|(_, row)| row.contains(&None)).map(|(node, _)| node).collect()
    }

    fn case(&self, case: usize, prediction: &[f64], free: &[usize]) -> Result<CaseErrors> {
        let (theta, truth) = (&self.thetas[case], &self.displacements[case]);
        ensure!(
            prediction.len() == truth.len() && prediction.iter().all(|u| u.is_finite()),
            "the prediction of test case {case} at theta = {theta:?} is not a finite displacement field"
        );
        let nodal = metrics::displacement_error(truth, prediction);
        let energy = |u: &[f64]| self.potential.value(u, theta);
        Ok(CaseErrors {
            err_u: free.iter().map(|&node| nodal[node]).collect(),
            err_f: metrics::deformation_gradient_error(&self.potential, truth, prediction),
            err_i1: metrics::first_invariant_error(&self.potential, truth, prediction),
            err_pi: metrics::relative_percent(energy(truth), energy(prediction)),
        })
    }
}

impl Evaluation {
    /// All errors: per free node and case, per element and case, per case.
    pub fn samples(&self) -> ErrorSamples {
        let gather = |of: fn(&CaseErrors) -> &[f64]| {
            self.cases.iter().flat_map(|case| of(case).iter().copied()).collect()
        };
        ErrorSamples {
            err_u_mm: gather(|case| &case.err_u),
            err_f_pct: gather(|case| &case.err_f),
            err_i1_pct: gather(|case| &case.err_i1),
            err_pi_pct: gather(|case| std::slice::from_ref(&case.err_pi)),
        }
    }

    /// Medians over all nodes or elements and cases.
    ///
    /// # Errors
    /// An error that is not a number.
    pub fn medians(&self) -> Result<PerMetric<f64>> {
        self.samples().try_map(|metric, mut values| {
            let found = quantiles(&mut values);
            found.map(|q| q.q50).with_context(|| format!("{} is not a number", metric.key()))
        })
    }

    /// One line per case for the table of samples.
    ///
    /// # Errors
    /// An error that is not a number.
    pub fn rows(&self, method: Method) -> Result<Vec<SampleRow>> {
        let spread = |values: &[f64]| {
            Spread::of(&mut values.to_vec()).context("an error of a test case is not a number")
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
        self.cases.iter().zip(&self.thetas).enumerate().map(row).collect()
    }

    /// Cases of median and of largest mean nodal error.
    pub fn median_and_worst(&self) -> [usize; 2] {
        let mean = |case: usize| {
            let errors = &self.cases[case].err_u;
            errors.iter().sum::<f64>() / errors.len() as f64
        };
        let mut order: Vec<usize> = (0..self.cases.len()).collect();
        order.sort_by(|&a, &b| mean(a).total_cmp(&mean(b)));
        [order[(order.len() - 1) / 2], order[order.len() - 1]]
    }
}
