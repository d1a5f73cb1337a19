//! Tests behind the warnings of a fit, and parameters of the equation that the data do not tell.

use crate::evidence::state::State;
use crate::fit::HoldOut;
use crate::fit::optimise::maximise;
use crate::fit::warning::Warning;
use crate::model::MEDIAN;
use crate::model::compile::Compiled;
use crate::model::data::{Role, largest, noise_name};
use crate::{Fit, Model, Noise, Result};
use sinew_num::ascending;

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
/// Least share of the median of the size of a standard normal variate that counts.
const SMALLEST: f64 = 1e-3;
/// Share of the largest of exact values from which on one that is missed contradicts others.
const MISSED: f64 = 1e-3;

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
        let lacks_values = !model.theta.is_empty() && !model.groups.iter().any(|g| observed(&g));
        warnings.extend(lacks_values.then_some(Warning::NothingMeasured));
        warnings.extend(self.outcome().collapsed.then_some(Warning::Collapsed));
        warnings.extend(self.silent()?.iter().map(|k| model.unidentified(*k)));
        warnings.extend(self.unresolved()?);
        warnings.extend(self.outliers()?);
        warnings.extend(self.unsettled.clone());
        Ok(warnings)
    }

    fn unresolved(&self) -> Result<Option<Warning>> {
        let found =
            self.hold_out.clone().map_or_else(|| self.left_out(), |known| Ok(Some(known)))?;
        let large = found.filter(|found| found.residual > RESOLVED * found.term);
        Ok(large.map(|HoldOut { at, residual, term }| Warning::Unresolved { at, residual, term }))
    }

    /// The value of each group, but for those of the equation, that the others predict worst, if that is too bad to be chance.
    fn outliers(&self) -> Result<Vec<Warning>> {
        let (model, conditional) = (self.model(), self.conditional()?);
        let mut outliers = Vec::new();
        let of_values = |g: &&Compiled<D>| g.given.operator.is_some() && !g.given.values.is_empty();
        for group in model.groups.iter().filter(of_values) {
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
            let missed = |own: usize| {
                let off = conditional.missed(group.offset + own).abs();
                off > MISSED * largest(&group.given.values).max(off)
            };
            let counts = |(own, z): &(usize, f64)| {
                far(*z) && (group.given.noise != Noise::Exact || missed(*own))
            };
            let found: Vec<(usize, f64)> = scores.into_iter().filter(counts).collect();
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

/// Standard deviation in units of that of the prior from which on a parameter has not contracted.
const WIDE: f64 = 0.5;
/// Such a deviation of a posterior that reaches a bound, so that data tell one side only.
const WIDE_AT_BOUND: f64 = 0.25;
/// Share of a range at its end, and least share of a posterior there that has reached it: two fifths of a prior's.
const SHARE_AT_END: f64 = 0.05;
const REACHED: f64 = 0.02;
/// Values of a parameter in its profile, and iterations for each.
const VALUES: usize = 20;
const ITERATIONS: usize = 100;
/// Decrease of the logarithm of the probability of the data beyond which a profile ends.
const PROFILE_END: f64 = 10.0;

impl<const D: usize> Fit<D> {
    /// Positions of parameters on which the probability of the data depends so little, with all others adjusted to them, that it is
    /// about as wide as their prior, and of others that are adjusted as widely; of all, where all variation of the data is taken for
    /// noise.
    pub(crate) fn silent(&self) -> Result<&[usize]> {
        let model = self.model();
        let found = self.silent.get_or_init(|| {
            if self.outcome().collapsed {
                return Ok(model.theta_range().collect());
            }
            let mut found = Vec::new();
            for k in model.theta_range() {
                let profile = self.profile(k)?;
                let of = |j: usize| profile.iter().map(move |(at, weight)| (at[j], *weight));
                if model.is_wide(k, of(k)) {
                    let adjusted = |j: &usize| model.contraction(*j, of(*j)).0 > WIDE_AT_BOUND;
                    found.extend(model.theta_range().filter(adjusted));
                }
            }
            Ok(ascending(found))
        });
        found.as_deref().map_err(Clone::clone)
    }

    /// Profile of a parameter: the most probable parameters at values over its range, and the probability of the data there, up to a
    /// factor; from the fit to both sides until next to nothing is left of it.
    fn profile(&self, k: usize) -> Result<Vec<(Vec<f64>, f64)>> {
        let (model, fitted) = (self.model(), &self.outcome().parameters);
        let of_data = |x: &[f64]| {
            let state = State::new(model, x)?;
            state.factored().map(|factored| state.in_full(&factored))
        };
        let mut bounds = model.scaled_bounds();
        let [lower, upper] = bounds[k];
        let value = |n: usize| lower + (n as f64 + 0.5) / VALUES as f64 * (upper - lower);
        let first = (0..VALUES).filter(|n| value(*n) < fitted[k]).count();
        let evaluate = |x: &[f64]| model.evaluate_posterior(x).ok();
        let (most, mut profile) = (of_data(fitted)?, Vec::new());
        for path in [(0..first).rev().collect::<Vec<_>>(), (first..VALUES).collect()] {
            let (mut before, mut at) = (fitted.clone(), fitted.clone());
            for n in path {
                // On along the way of the others: ridges are followed by short descents.
                let mut start: Vec<_> = at.iter().zip(&before).map(|(x, b)| 2.0 * x - b).collect();
                start[k] = value(n);
                bounds[k] = [start[k]; 2];
                let found = maximise(evaluate, &start, &bounds, ITERATIONS);
                let Some(found) = found else { break };
                before = std::mem::replace(&mut at, found.point);
                let log = of_data(&at)? - most;
                profile.push((at.clone(), log.min(PROFILE_END).exp()));
                if log < -PROFILE_END {
                    break;
                }
            }
        }
        Ok(profile)
    }
}

impl<const D: usize> Model<D> {
    /// Whether values of a parameter with weights are about as wide as its prior, or half as wide at a bound.
    pub(crate) fn is_wide(&self, k: usize, values: impl Iterator<Item = (f64, f64)>) -> bool {
        let (deviation, at_bound) = self.contraction(k, values);
        deviation > if at_bound { WIDE_AT_BOUND } else { WIDE }
    }

    /// Standard deviation of values of a parameter with weights in units of that of its prior, and whether they reach a bound.
    fn contraction(&self, k: usize, values: impl Iterator<Item = (f64, f64)>) -> (f64, bool) {
        let [lower, upper] = self.scaled_bounds()[k];
        let shares: Vec<_> = values.map(|(x, w)| ((x - lower) / (upper - lower), w)).collect();
        let whole: f64 = shares.iter().map(|(_, w)| w).sum();
        let mean =
            |of: &dyn Fn(f64) -> f64| shares.iter().map(|(x, w)| w * of(*x)).sum::<f64>() / whole;
        let near = |end: f64| mean(&|x| f64::from(u8::from((x - end).abs() < SHARE_AT_END)));
        let centre = mean(&|x| x);
        let deviation = (12.0 * mean(&|x| (x - centre).powi(2))).sqrt();
        (deviation, near(0.0).max(near(1.0)) > REACHED)
    }

    /// Warning of a parameter that the data do not tell.
    pub(crate) fn unidentified(&self, k: usize) -> Warning {
        Warning::Unidentified { parameter: self.parameters[k].name.clone() }
    }
}
