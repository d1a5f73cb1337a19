//! Points where the equation is off, and what stays off as noise.

use crate::fit::HoldOut;
use crate::fit::hold_out::{Candidate, EVEN};
use crate::model::data::{Group, Role};
use crate::{Data, Domain, Fit, FitOptions, GpError, Model, Noise, Prior, Result, Side};
use rayon::prelude::*;
use std::sync::Arc;

/// Growth of the number of points in a round.
const GROWTH: f64 = 0.5;
/// Error of the equation relative to its largest term at which points suffice, and where u alone is sought of one that holds
/// everywhere.
pub(crate) const RESOLVED: f64 = 0.02;
pub(crate) const RESOLVED_ALONE: f64 = 1e-3;
/// Values up to which that suffices: more of them say more of u, and the equation must be off by as much less.
const FEW_VALUES: f64 = 100.0;
/// Width of a layer at one end of an axis in units of its length, and share of the error that is left where there is one.
const WIDTH: f64 = 0.02;
const LAYER: f64 = 0.5;
/// Distance of new points from others, in units of that of as many evenly spread ones.
const APART: f64 = 0.3;

impl<const D: usize> Model<D> {
    /// Error of the equation relative to its largest term at which points suffice.
    pub(super) fn aim(&self) -> f64 {
        if self.theta.is_empty() && self.source.is_some() {
            return RESOLVED_ALONE;
        }
        let observed = self.groups.iter().filter(|group| group.given.role == Role::Observed);
        let values = observed.map(|group| match &group.given.averages {
            Some(averages) => averages.counts.iter().sum(),
            None => group.given.values.len() as f64,
        });
        RESOLVED * (FEW_VALUES / values.sum::<f64>().max(FEW_VALUES)).sqrt()
    }

    /// Model of the same equation with another prior or more points.
    fn rebuilt(&self, prior: Prior<D>, groups: Vec<Group<D>>) -> Result<Self> {
        let model = Self::new(prior, Data { groups, everywhere: None }, self.evidence)?;
        Ok(Self { source: self.source.clone(), ..model })
    }

    pub(super) fn check_memory(&self, options: &FitOptions) -> Result<()> {
        // Covariance, its cotangents and an inverse.
        let [gigabytes, most] =
            [24.0 * (self.size as f64).powi(2), options.most_memory].map(|bytes| bytes / 1e9);
        match gigabytes <= most {
            true => Ok(()),
            false => Err(GpError::TooLarge { observations: self.size, gigabytes, most }),
        }
    }
}

/// Places for so many further points, where the equation is off most, apart from those known and from each other.
pub(crate) fn spread_out<const D: usize>(
    mut candidates: Vec<Candidate<D>>,
    known: &[[f64; D]],
    wanted: usize,
    domain: &Domain<D>,
) -> Vec<Candidate<D>> {
    candidates.sort_by(|a, b| b.residual.abs().total_cmp(&a.residual.abs()));
    let apart = APART * ((known.len() + wanted) as f64).powf(-1.0 / D as f64);
    let mut chosen: Vec<Candidate<D>> = Vec::new();
    for candidate in candidates {
        let mut taken = known.iter().chain(chosen.iter().map(|other| &other.at));
        if chosen.len() < wanted && taken.all(|other| domain.apart(&candidate.at, other) >= apart) {
            chosen.push(candidate);
        }
    }
    chosen
}

impl<const D: usize> Fit<D> {
    /// The model with points of its equation where that is off most; none where its right-hand side is known at its points only, or
    /// there are enough of them.
    pub(super) fn with_more_points(
        &self,
        options: &FitOptions,
        round: u64,
    ) -> Result<Option<Model<D>>> {
        let model = self.model();
        let known = model.places();
        if model.source.is_none() && known.len() < EVEN {
            return Ok(None);
        }
        let room = options.most_points.saturating_sub(known.len());
        let wanted = ((GROWTH * known.len() as f64) as usize).max(2).min(room);
        let chosen = spread_out(self.candidates(round)?, &known, wanted, &model.prior.domain);
        let mut groups = model.given.clone();
        let exact = groups.iter_mut().find(|g| g.operator.is_none() && g.noise == Noise::Exact);
        let Some(group) = exact.filter(|_| !chosen.is_empty()) else { return Ok(None) };
        group.legs[0].1.extend(chosen.iter().map(|candidate| candidate.at));
        group.values.extend(chosen.iter().map(|candidate| candidate.value));
        model.rebuilt(model.prior.clone(), groups).map(Some)
    }

    /// The fit with the axis stretched next to one end, and its error, where that leaves less of it than [`LAYER`].
    pub(super) fn stretched(self, found: HoldOut, options: &FitOptions) -> Result<(Self, HoldOut)> {
        let model = self.model();
        let prior = &model.prior;
        let taken = prior.stretches.iter().any(Option::is_some);
        if taken || prior.domain.cross_section().is_some() || self.candidates(0)?.is_empty() {
            return Ok((self, found));
        }
        let (names, extents) = (prior.domain.names(), prior.domain.extents());
        let ends: Vec<(usize, Side)> =
            (0..D).flat_map(|d| Side::BOTH.map(|side| (d, side))).collect();
        let tried = |(d, side): (usize, Side)| -> Result<(Self, HoldOut)> {
            let prior = prior.clone().stretched(&names[d], side, WIDTH * extents[d])?;
            let own = model.rebuilt(prior, model.given.clone())?;
            let fit = own.fit_from(vec![self.outcome().parameters.clone()], options.iterations)?;
            let error = fit.left_out()?;
            Ok((fit, error.unwrap_or_else(|| found.clone())))
        };
        let tried: Vec<_> = ends.into_par_iter().filter_map(|end| tried(end).ok()).collect();
        // Next to nothing is off of an equation whose solution is next to nothing.
        let lost = |fit: &Self| fit.outcome().collapsed && !self.outcome().collapsed;
        let tried = tried.into_iter().filter(|(fit, _)| !lost(fit));
        let error = |found: &HoldOut| found.residual / found.term;
        let best = tried.min_by(|a, b| error(&a.1).total_cmp(&error(&b.1)));
        Ok(match best.filter(|(_, own)| error(own) < LAYER * error(&found)) {
            Some(better) => better,
            None => (self, found),
        })
    }

    /// The fit with the error of collocation as noise of an equation that was exact, from the parameters before: so that
    /// intervals and bands are as much wider as the points leave open. As it was where that error is next to nothing.
    pub(super) fn with_collocation_error(
        mut self,
        found: HoldOut,
        iterations: usize,
    ) -> Result<Self> {
        let model = self.model();
        let enough = if model.theta.is_empty() { RESOLVED } else { model.aim() };
        if found.residual <= enough * found.term {
            self.hold_out = Some(found);
            return Ok(self);
        }
        let start = self.outcome().parameters.clone();
        let mut model = Arc::unwrap_or_clone(self.model);
        let given = model.groups.iter_mut().map(|group| &mut group.given);
        for exact in given.filter(|g| g.operator.is_none() && g.noise == Noise::Exact) {
            exact.noise = Noise::Known(found.residual);
        }
        let mut fit = model.fit_from(vec![start], iterations)?;
        // As the last and best after others.
        fit.best += self.restarts.len();
        fit.restarts.splice(0..0, self.restarts);
        Ok(Fit { unsettled: self.unsettled, hold_out: Some(found), ..fit })
    }
}
