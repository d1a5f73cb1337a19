//! Warnings about an answer, in words, and the tests behind those of a fit.

use crate::error::place;
use crate::fit::HoldOut;
use crate::model::compile::Compiled;
use crate::model::data::{Role, noise_name};
use crate::{Fit, Model, Noise, Result};
use thiserror::Error;

/// Why an answer may be worth less than it looks.
///
/// ```
/// use sinew_gp::{
///     Data, Domain, Evidence, FitOptions, Model, Noise, Prior, Problem, Warning, squared_exponential,
/// };
///
/// let domain = Domain::interval("x", [0.0, 1.0])?;
/// let [dx] = domain.derivatives();
/// let prior = Prior::constrained(&Problem::new(domain, dx * dx)?, &squared_exponential())?;
/// let data = Data::new()
///     .values(&[[0.4]], &[1.0], Noise::Learned)
///     .equation(&[[0.5]], &[0.0], Noise::Exact);
/// let fit = Model::new(prior, data, Evidence::Auto)?.fit(&FitOptions::default())?;
/// let few = Warning::FewValues { noise: "noise 1".into(), values: 1 };
/// assert!(fit.warnings()?.contains(&few));
/// # Ok::<(), sinew_gp::GpError>(())
/// ```
#[derive(Clone, Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Warning {
    /// A parameter of the equation, or a learned noise, at an end of its range.
    #[error(
        "{parameter} ends at its bound {bound:e}: the posterior is largest there or beyond it; widen the bounds, or read its interval as one-sided"
    )]
    AtBound { parameter: String, bound: f64 },
    /// A parameter of the equation that the data do not tell.
    #[error(
        "unidentified: the data say next to nothing of {parameter}; measure elsewhere, or hold one of the parameters"
    )]
    Unidentified { parameter: String },
    /// No values to learn the equation's parameters from.
    #[error(
        "no value of u is measured, so that the equation's parameters follow from the prior alone; add values of u"
    )]
    NothingMeasured,
    /// Fewer values than a level of noise can be told from.
    #[error(
        "{noise} is learned from {values} values only, so that its prior decides; state the noise, or add values"
    )]
    FewValues { noise: String, values: usize },
    /// See [`crate::Outcome::collapsed`].
    #[error(
        "all variation of the values is taken for noise: the trivial solution, or data without information; compare restarts, or add collocation points"
    )]
    Collapsed,
    /// The equation predicts at its own points what it is not given there, worse than a tenth of its terms.
    #[error(
        "left out, the equation at {} is off by {residual:.1e} where its terms are of the size {term:.1e}: too few collocation points, or conditions, values and equation that contradict each other; add points there and compare",
        place(at)
    )]
    Unresolved { at: Vec<f64>, residual: f64, term: f64 },
    /// A value that the others predict far worse than its noise allows.
    #[error(
        "value {value} of the group of {noise} at {}, {measured:.4}, is {:.0} standard deviations from what all other data predict{}; check it, leave it out, or take `Noise::StudentT`",
        place(at), z.abs(), and_others(*others)
    )]
    Outlier { noise: String, value: usize, at: Vec<f64>, measured: f64, z: f64, others: usize },
    /// Importance weights of [`crate::laplace`] with a tail so heavy that its averages cannot be trusted.
    #[error(
        "importance weights are heavy-tailed (k̂ = {k_hat:.2}, above 0.4): Laplace's approximation misses much of the posterior; draw by `nuts`"
    )]
    HeavyWeights { k_hat: f64 },
    /// Chains of [`crate::nuts`] that do not agree.
    #[error(
        "chains disagree on {parameter} (R̂ = {r_hat:.2}, {effective:.0} effective draws); raise `NutsOptions::warmup` and `draws`"
    )]
    NotMixed { parameter: String, r_hat: f64, effective: f64 },
    /// A most probable value outside of what nearly all draws say.
    #[error(
        "the most probable {parameter}, {mode:.4e}, lies outside of 99 % of the draws, {lower:.4e} to {upper:.4e}: the posterior has a narrow maximum apart from most of its mass; report the draws' interval and median"
    )]
    ModeApart { parameter: String, mode: f64, lower: f64, upper: f64 },
    /// Intervals that still moved when collocation points ran out.
    #[error(
        "intervals still move with {points} collocation points; raise `FitOptions::most_points`, or stretch the axis by `Prior::stretched` where the solution is steep"
    )]
    Unsettled { points: usize },
}

fn and_others(others: usize) -> String {
    match others {
        0 => String::new(),
        1 => ", and so is one other".into(),
        count => format!(", and so are {count} others"),
    }
}

/// Values below which a level of noise is mostly what is believed of it: the standard deviation of its logarithm from n
/// values is about (2n)^−½.
const FEW: usize = 4;
/// Share of an interval within which its end counts as reached.
const END: f64 = 1e-6;
/// Residual of left-out points, in units of the equation's largest term, that is resolved.
const RESOLVED: f64 = 0.1;
/// Values of a group that are left out at most, for time.
const MOST_VALUES: usize = 400;
/// Leave-one-out residual in its standard deviations that is no chance: 1e-5 for one of a hundred normal values.
const FAR: f64 = 5.0;
/// Such a residual in units of their median, where noise is learned, and least in standard deviations.
const FAR_LEARNED: f64 = 7.0;
const LEAST_FAR: f64 = 2.0;
/// Such a residual in units of the size of the others; 1e-3 for the largest of 25 normal values.
const STUDENTISED: f64 = 6.0;
/// Values from which on their median is known well enough.
const ENOUGH: usize = 8;
/// Median of the size of a standard normal variate, and least share of it that counts.
const MEDIAN: f64 = 0.6745;
const SMALLEST: f64 = 1e-3;

impl<const D: usize> Fit<D> {
    /// Warnings about the fit; empty if no fault was found. Takes about as many evaluations of the evidence's gradient as the fit of
    /// one start for each parameter of the equation, when first asked.
    ///
    /// # Errors
    /// If the evidence cannot be evaluated next to the fit.
    pub fn warnings(&self) -> Result<Vec<Warning>> {
        instance!(D, Fit::faults, fn(&Fit<D>) -> Result<Vec<Warning>>)(self)
    }

    fn faults(&self) -> Result<Vec<Warning>> {
        let model = self.model();
        let mut warnings = at_bounds(model, &self.outcome().parameters);
        let observed = |g: &&Compiled<D>| g.given.role == Role::Observed;
        for group in model.groups.iter().filter(observed) {
            if let (Some(noise), true) = (group.learned, group.given.values.len() < FEW) {
                let noise = model.parameters[noise].name.clone();
                warnings.push(Warning::FewValues { noise, values: group.given.values.len() });
            }
        }
        if !model.theta.is_empty() && !model.groups.iter().any(|g| observed(&g)) {
            warnings.push(Warning::NothingMeasured);
        }
        if self.outcome().collapsed {
            warnings.push(Warning::Collapsed);
        }
        warnings.extend(self.silent()?.iter().map(|k| model.unidentified(*k)));
        warnings.extend(self.unresolved()?);
        warnings.extend(self.outliers()?);
        warnings.extend(self.unsettled.map(|points| Warning::Unsettled { points }));
        Ok(warnings)
    }

    fn unresolved(&self) -> Result<Option<Warning>> {
        let found =
            self.hold_out.clone().map_or_else(|| self.left_out(), |known| Ok(Some(known)))?;
        let large = found.filter(|found| found.residual > RESOLVED * found.term);
        Ok(large.map(|HoldOut { at, residual, term }| Warning::Unresolved { at, residual, term }))
    }

    /// The value of each group of measurements that the others predict worst, if that is too bad to be chance.
    fn outliers(&self) -> Result<Vec<Warning>> {
        let (model, conditional) = (self.model(), self.conditional()?);
        let mut outliers = Vec::new();
        let noisy =
            |g: &&Compiled<D>| g.given.role == Role::Observed && g.given.noise != Noise::Exact;
        for group in model.groups.iter().filter(noisy) {
            let score = |row: usize| {
                let [residual, deviation] = conditional.left_out(row);
                residual / deviation
            };
            let step = 1 + group.given.values.len() / MOST_VALUES;
            let numbered = group.rows().enumerate().step_by(step);
            let scores: Vec<(usize, f64)> = numbered.map(|(own, row)| (own, score(row))).collect();
            // Learned noise is as large as the outlier makes it: others then are closer than their deviation says.
            let mut sizes: Vec<f64> = scores.iter().map(|(_, z)| z.abs()).collect();
            sizes.sort_by(f64::total_cmp);
            let typical = (sizes[sizes.len() / 2] / MEDIAN).clamp(SMALLEST, 1.0);
            let learned = group.learned.is_some() && sizes.len() >= ENOUGH;
            // Without the value itself (externally studentised), and against the median where others mask it.
            let squares: f64 = sizes.iter().map(|z| z * z).sum();
            let others = |z: f64| ((squares - z * z) / (sizes.len() as f64 - 2.0)).max(0.0).sqrt();
            let far = |z: f64| {
                let masked = z.abs() > FAR_LEARNED * typical && z.abs() > LEAST_FAR;
                z.abs() > FAR || learned && (masked || z.abs() > STUDENTISED * others(z))
            };
            let found: Vec<(usize, f64)> = scores.into_iter().filter(|(_, z)| far(*z)).collect();
            let worst = found.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            let Some((value, z)) = worst.copied() else { continue };
            let (noise, at) = (noise_name(group.number), group.given.points()[value].to_vec());
            let (measured, others) = (group.given.values[value], found.len() - 1);
            outliers.push(Warning::Outlier { noise, value, at, measured, z, others });
        }
        Ok(outliers)
    }
}

fn at_bounds<const D: usize>(model: &Model<D>, scaled: &[f64]) -> Vec<Warning> {
    let theta = model.theta_range();
    let learned = |k: usize| model.groups.iter().any(|g| g.learned == Some(k));
    let watched = (0..scaled.len()).filter(|k| theta.contains(k) || learned(*k));
    let bounds = model.scaled_bounds();
    let reached = |k: usize| {
        let (own, [lower, upper]) = (&model.parameters[k], bounds[k]);
        let near = END * (upper - lower);
        let ends = [scaled[k] - lower <= near, upper - scaled[k] <= near];
        let bound = own.bounds[ends.iter().position(|reached| *reached)?];
        Some(Warning::AtBound { parameter: own.name.clone(), bound })
    };
    watched.filter_map(reached).collect()
}
