//! Tests behind the warnings of a fit.

use crate::fit::HoldOut;
use crate::fit::warning::Warning;
use crate::model::MEDIAN;
use crate::model::compile::Compiled;
use crate::model::data::{Role, largest, noise_name};
use crate::{Fit, Model, Noise, Result};

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
        if !model.theta.is_empty() && !model.groups.iter().any(|g| observed(&g)) {
            warnings.push(Warning::NothingMeasured);
        }
        if self.outcome().collapsed {
            warnings.push(Warning::Collapsed);
        }
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
