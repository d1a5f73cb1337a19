//! Errors over test cases, thesis (3.22) and (3.24).

use crate::error::ensure;
use crate::sample::simulate::Simulations;
use crate::{Body, Error, Result};
use serde::{Deserialize, Serialize};
use sinew_energy::{Barriers, metrics};
use sinew_num::{in_parallel, norm};
use std::time::Instant;

/// Test cases with their true displacements.
#[derive(Clone, Debug)]
pub struct TestSet<'b> {
    /// The body.
    pub body: &'b Body,
    /// Parameters, case by case.
    pub thetas: Vec<Vec<f64>>,
    /// True displacements, case by case \[length\].
    pub fields: Vec<Vec<f64>>,
    /// Median wall time of the solves \[s\].
    pub median_solve_s: f64,
}

/// Errors of one case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseErrors {
    /// `‖u − û‖` per node that some support leaves free \[length\]: clamped ones are exact for every method and would
    /// flatter the medians.
    pub err_u: Vec<f64>,
    /// `‖F − F̂‖ / ‖F‖` per quadrature point [%].
    pub err_f: Vec<f64>,
    /// `|I₁ − Î₁| / I₁` per quadrature point [%].
    pub err_i1: Vec<f64>,
    /// `|Π − Π̂| / |Π|` [%]; barriers keep the energy of an inverted prediction finite.
    pub err_pi: f64,
    /// `|V − V̂| / V` of each cavity [%].
    pub err_volume: Vec<f64>,
    /// `‖u − û‖ / ‖u‖` over all nodes together.
    pub relative: f64,
    /// Whether the prediction inverts a cell, so that its energy is infinite.
    pub inverted: bool,
    /// Energy above the minimum, relative to it.
    pub energy_excess: f64,
}

/// An error measure of thesis (3.22).
#[derive(Clone, Copy, Debug)]
pub struct Metric {
    /// Name, such as `err_u`.
    pub name: &'static str,
    /// The quantity in words.
    pub quantity: &'static str,
    /// Definition.
    pub about: &'static str,
    /// Whether it has the unit of length; others are in %.
    pub is_length: bool,
    of: fn(&CaseErrors) -> &[f64],
}

/// The error measures in the order of the thesis' tables.
pub const METRICS: [Metric; 4] = [
    Metric {
        name: "err_u",
        quantity: "displacement",
        about: "‖u − û‖₂ at every node that is free to move; u is the reference, û the prediction",
        is_length: true,
        of: |case| &case.err_u,
    },
    Metric {
        name: "err_F",
        quantity: "deformation gradient",
        about: "‖F − F̂‖_F / ‖F‖_F at every quadrature point",
        is_length: false,
        of: |case| &case.err_f,
    },
    Metric {
        name: "err_I₁",
        quantity: "first invariant",
        about: "|I₁ − Î₁| / I₁ at every quadrature point",
        is_length: false,
        of: |case| &case.err_i1,
    },
    Metric {
        name: "err_Π",
        quantity: "potential energy",
        about: "|Π − Π̂| / |Π| of every test case",
        is_length: false,
        of: |case| std::slice::from_ref(&case.err_pi),
    },
];

impl Metric {
    /// Errors in one case: per free node, per quadrature point, or one.
    pub fn of<'a>(&self, case: &'a CaseErrors) -> &'a [f64] {
        (self.of)(case)
    }

    /// Errors in all cases.
    pub fn pooled<'a>(&'a self, cases: &'a [CaseErrors]) -> impl Iterator<Item = f64> + 'a {
        cases.iter().flat_map(|case| self.of(case).iter().copied())
    }

    /// Unit of its errors: `length` for lengths, else `%`.
    pub fn unit<'a>(&self, length: &'a str) -> &'a str {
        if self.is_length { length } else { "%" }
    }
}

/// Quantiles of the errors over all cases, with nodes and quadrature points pooled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Nodal distance \[length\].
    pub err_u: Quantiles,
    /// Deformation gradient [%].
    pub err_f: Quantiles,
    /// First invariant [%].
    pub err_i1: Quantiles,
    /// Total potential energy [%].
    pub err_pi: Quantiles,
    /// Cavity volumes [%], where there are cavities.
    pub err_volume: Option<Quantiles>,
    /// `‖u − û‖ / ‖u‖` per case.
    pub relative: Quantiles,
}

impl<'b> TestSet<'b> {
    /// Test set from simulations; those that failed are no cases.
    pub fn new(body: &'b Body, simulations: Simulations) -> Self {
        let median_solve_s = median(&simulations.solve_seconds);
        Self { body, thetas: simulations.thetas, fields: simulations.fields, median_solve_s }
    }

    /// Errors of `fields`, one displacement per case, in the same order.
    ///
    /// # Errors
    /// A number of fields, or a field, that does not fit or is not finite.
    pub fn cases(&self, fields: &[Vec<f64>]) -> Result<Vec<CaseErrors>> {
        let (found, expected) = (fields.len(), self.thetas.len());
        let length = self.body.prescribed.len();
        let fits = |field: &Vec<f64>| field.len() == length && field.iter().all(|u| u.is_finite());
        let all_fit = found == expected && fields.iter().all(fits);
        ensure(all_fit, misfits(found, expected, length))?;
        let guarded = self.body.clone().with_barriers(Barriers::default());
        let free = self.body.free_nodes();
        let case = |case: usize| self.case(&guarded, case, &fields[case], &free);
        Ok(in_parallel(0..expected, case))
    }

    /// Quantiles of the errors of `fields`.
    ///
    /// # Errors
    /// As [`TestSet::cases`].
    pub fn errors(&self, fields: &[Vec<f64>]) -> Result<Errors> {
        Ok(Errors::of(&self.cases(fields)?))
    }

    fn case(&self, body: &Body, case: usize, estimate: &[f64], free: &[usize]) -> CaseErrors {
        let (theta, truth) = (&self.thetas[case], &self.fields[case]);
        let nodal = metrics::displacement_error(truth, estimate);
        let (energy, minimum) = (body.value(estimate, theta), body.value(truth, theta));
        let volumes = self.body.cavity_volumes(truth).into_iter();
        let volumes = volumes.zip(self.body.cavity_volumes(estimate));
        CaseErrors {
            err_u: free.iter().map(|&node| nodal[node]).collect(),
            err_f: metrics::deformation_gradient_error(body, truth, estimate),
            err_i1: metrics::first_invariant_error(body, truth, estimate),
            err_pi: share(100.0 * (energy - minimum).abs(), minimum.abs()),
            err_volume: volumes.map(|(a, b)| share(100.0 * (a - b).abs(), a.abs())).collect(),
            relative: share(norm(&nodal), norm(truth)),
            inverted: !self.body.value(estimate, theta).is_finite(),
            energy_excess: share(energy - minimum, minimum.abs()),
        }
    }
}

/// Error of fields that do not suit test cases.
pub(crate) fn misfits(found: usize, expected: usize, length: usize) -> Error {
    Error::Refused(format!(
        "{found} fields for {expected} test cases, or a field that is not {length} finite numbers long"
    ))
}

/// Measure by which weights, fits and recipes are chosen: root mean square of `‖u − û‖ / ‖u‖` over the cases, times one
/// plus the share of inverted predictions. Of two similar candidates the admissible one is chosen.
///
/// A case with u = 0 has no finite relative error unless its prediction is exact. It counts as 0, so that the other cases
/// decide. Without other cases the result is the largest number.
pub fn root_mean_square(cases: &[CaseErrors]) -> f64 {
    let squared = cases.iter().map(|case| case.relative.powi(2));
    let finite: Vec<f64> = squared.filter(|square| !square.is_infinite()).collect();
    let squares = if finite.is_empty() { f64::MAX } else { finite.iter().sum() };
    let share = |count: usize| count as f64 / cases.len() as f64;
    let inverted = share(cases.iter().filter(|case| case.inverted).count());
    // JSON cannot store infinity.
    ((1.0 + inverted) * (squares / cases.len() as f64).sqrt()).min(f64::MAX)
}

/// A difference divided by a size: 0 for a zero difference, else clamped to finite numbers, which can be stored.
pub(crate) fn share(difference: f64, size: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { (difference / size).clamp(f64::MIN, f64::MAX) }
}

impl Errors {
    /// Error quantiles over cases; nodes and quadrature points are pooled.
    pub fn of(cases: &[CaseErrors]) -> Self {
        let [err_u, err_f, err_i1, err_pi] =
            METRICS.map(|metric| Quantiles::of(metric.pooled(cases)));
        let mut volumes = cases.iter().flat_map(|case| case.err_volume.iter().copied()).peekable();
        let err_volume = volumes.peek().is_some().then(|| Quantiles::of(volumes));
        let relative = Quantiles::of(cases.iter().map(|case| case.relative));
        Self { err_u, err_f, err_i1, err_pi, err_volume, relative }
    }
}

/// Cases of median and of largest mean nodal error.
///
/// # Panics
/// Without cases.
pub fn median_and_worst(cases: &[CaseErrors]) -> [usize; 2] {
    let mean = |case: usize| {
        let errors = &cases[case].err_u;
        errors.iter().sum::<f64>() / errors.len() as f64
    };
    let mut order: Vec<usize> = (0..cases.len()).collect();
    order.sort_by(|&a, &b| mean(a).total_cmp(&mean(b)));
    [order[(order.len() - 1) / 2], order[order.len() - 1]]
}

/// Quantiles by linear interpolation between order statistics, and the largest value. A value that is not finite counts as the largest
/// number (`f64::MAX`): files in JSON hold finite numbers alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// The least.
    pub min: f64,
    /// 2.5 %.
    pub q02_5: f64,
    /// 5 %.
    pub q05: f64,
    /// 25 %.
    pub q25: f64,
    /// The median.
    pub q50: f64,
    /// 75 %.
    pub q75: f64,
    /// 95 %.
    pub q95: f64,
    /// 97.5 %.
    pub q97_5: f64,
    /// The largest.
    pub max: f64,
    /// The mean.
    pub mean: f64,
}

impl Quantiles {
    /// Quantiles of values; all NaN without any.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let finite = |v: f64| if v.is_nan() { f64::MAX } else { v.clamp(f64::MIN, f64::MAX) };
        let mut sorted: Vec<f64> = values.into_iter().map(finite).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = share * (sorted.len() as f64 - 1.0);
            let value = |at: f64| sorted.get(at as usize).copied().unwrap_or(f64::NAN);
            let [low, high] = [place.floor(), place.ceil()].map(value);
            if low == high { low } else { low + place.fract() * (high - low) }
        };
        let mean = (sorted.iter().sum::<f64>() / sorted.len() as f64).clamp(f64::MIN, f64::MAX);
        let [min, q02_5, q05, q25] = [0.0, 0.025, 0.05, 0.25].map(at);
        let [q50, q75, q95, q97_5, max] = [0.5, 0.75, 0.95, 0.975, 1.0].map(at);
        Self { min, q02_5, q05, q25, q50, q75, q95, q97_5, max, mean }
    }
}

/// Median wall time of `repeats` calls after one that warms up \[s\].
///
/// # Errors
/// The first error of a call.
pub(crate) fn median_seconds<T, E>(
    repeats: usize,
    mut call: impl FnMut() -> Result<T, E>,
) -> Result<f64, E> {
    call()?;
    let mut seconds = Vec::with_capacity(repeats);
    for _ in 0..repeats.max(1) {
        let start = Instant::now();
        std::hint::black_box(call()?);
        seconds.push(start.elapsed().as_secs_f64());
    }
    Ok(median(&seconds))
}

/// The upper median; NaN of nothing.
pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Does some work and adds its wall time to `total` \[s\].
pub fn timed<T>(total: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let done = work();
    *total += start.elapsed().as_secs_f64();
    done
}
