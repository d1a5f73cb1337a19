//! The error of collocation, from places that the fit does not know of: more points where the equation is off, and what stays off
//! as noise.

use crate::fit::HoldOut;
use crate::model::compile::Compiled;
use crate::model::data::{Group, Role, root_mean_square};
use crate::{Data, Domain, Fit, FitOptions, GpError, Model, Noise, Operator, Prior, Result, Side};
use sinew_num::in_parallel;
use sinew_sample::quantile;
use std::sync::Arc;

/// Points that are left out at most, for time.
const MOST_LEFT_OUT: usize = 200;
/// Places where the equation is looked at, and their seed.
pub(crate) const PLACES: usize = 300;
const SEED: u64 = 0x0a11;
/// Share of the left-hand side's standard deviation before the data below which terms count as zero: a residual is not held
/// against what is next to nothing.
const NOTHING: f64 = 1e-3;
/// Number of places for each of them where a right-hand side is looked for beyond its range there, by more than that range.
const FINER: usize = 10;
/// Points at which a right-hand side is the same, from which on it is taken to be the same in the box that they fill.
const EVEN: usize = 10;
/// Distance of the box's faces from the points, in units of that of as many evenly spread ones.
const MARGIN: f64 = 0.5;

/// A place where the equation may be imposed.
pub(crate) struct Candidate<const D: usize> {
    pub at: [f64; D],
    /// The right-hand side.
    pub value: f64,
    /// Error of the left-hand side of the posterior mean.
    pub residual: f64,
}

/// Error of the equation in units of its largest term from which on intervals are withheld.
const WITHHELD: f64 = 2.0;

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
    /// Groups of values of the right-hand side.
    fn equations(&self) -> impl Iterator<Item = &Compiled<D>> {
        let of_equation = |group: &&Compiled<D>| {
            group.given.operator.is_none() && !group.given.points().is_empty()
        };
        self.groups.iter().filter(of_equation)
    }

    /// All collocation points.
    pub(crate) fn places(&self) -> Vec<[f64; D]> {
        self.equations().flat_map(|group| group.given.points().iter().copied()).collect()
    }

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
        Ok(Self { source: self.source.clone(), even: self.even, ..model })
    }

    /// The right-hand side that is the same at all points of an exact equation, and the box that they fill.
    pub(crate) fn even_source(&self) -> Option<(f64, [[f64; 2]; D])> {
        let mut equations = self.equations();
        let Group { values, noise, legs, .. } = &equations.next()?.given;
        let even = values.len() >= EVEN && values.iter().all(|value| *value == values[0]);
        let ends = |d: usize| {
            let along: Vec<f64> = legs[0].1.iter().map(|x| x[d]).collect();
            let [lower, upper] = [0.0, 1.0].map(|share| quantile(&along, share));
            let margin = MARGIN * (upper - lower) * (values.len() as f64).powf(-1.0 / D as f64);
            [lower - margin, upper + margin]
        };
        let alone = *noise == Noise::Exact && equations.next().is_none();
        (even && alone).then(|| (values[0], std::array::from_fn(ends)))
    }

    pub(super) fn check_memory(&self, options: &FitOptions) -> Result<()> {
        // Covariance, its cotangents and an inverse.
        let [gigabytes, most] =
            [24.0 * (self.size as f64).powi(2), options.most_memory].map(|bytes| bytes / 1e9);
        let too_large = GpError::TooLarge { observations: self.size, gigabytes, most };
        if gigabytes <= most { Ok(()) } else { Err(too_large) }
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
    /// Error in place of intervals of an equation that next to nothing was seen of.
    pub(crate) fn withheld(&self) -> Option<GpError> {
        let HoldOut { at, residual, term } = self.hold_out.clone()?;
        (residual > WITHHELD * term).then_some(GpError::Unresolved { at, residual, term })
    }

    /// The equation left out at each of its points in turn, by the inverse of the covariance; and at other places where its
    /// right-hand side is known, because it holds everywhere or is the same at all points. None without an equation.
    pub(crate) fn left_out(&self) -> Result<Option<HoldOut>> {
        let (model, conditional) = (self.model(), self.conditional()?);
        let (mut own, mut term) = (Vec::new(), 0.0_f64);
        for group in model.equations() {
            let at = group.given.points();
            term = term.max(NOTHING * conditional.prior_spread(&model.prior.equation, at)?);
            for (row, at) in group.rows().zip(at).step_by(1 + at.len() / MOST_LEFT_OUT) {
                own.push((conditional.left_out(row)[0], *at));
            }
            for summand in model.prior.equation.terms() {
                let values = conditional.mean_of(&Operator::of(summand), at)?;
                term = term.max(root_mean_square(&values));
            }
        }
        let elsewhere = self.candidates(SEED)?.into_iter();
        let elsewhere: Vec<_> = elsewhere.map(|place| (place.residual, place.at)).collect();
        let size = |found: &[(f64, [f64; D])]| {
            root_mean_square(&found.iter().map(|(residual, _)| *residual).collect::<Vec<_>>())
        };
        let worse = if size(&elsewhere) > size(&own) { elsewhere } else { own };
        let worst = worse.iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        let residual = size(&worse);
        Ok(worst.map(|(_, at)| HoldOut { at: at.to_vec(), residual, term }))
    }

    /// Places with the residual of the equation there, where its right-hand side is known; else none.
    pub(crate) fn candidates(&self, seed: u64) -> Result<Vec<Candidate<D>>> {
        let model = self.model();
        if model.source.is_none() && model.even.is_none() {
            return Ok(Vec::new());
        }
        let inside = |x: &[f64; D], ends: &[[f64; 2]; D]| {
            x.iter().zip(ends).all(|(x, [lower, upper])| lower <= x && x <= upper)
        };
        let known = |x: [f64; D]| {
            let f = match &model.source {
                Some(source) => source.value(x),
                None => model.even.filter(|(_, ends)| inside(&x, ends))?.0,
            };
            Some((x, f))
        };
        let places = model.prior.domain.sample(FINER * PLACES, seed)?.into_iter();
        let mut places: Vec<([f64; D], f64)> = places.filter_map(known).collect();
        let finer = places.split_off(PLACES.min(places.len()));
        let seen: Vec<f64> = places.iter().map(|(_, f)| *f).collect();
        let [lower, upper] = [0.0, 1.0].map(|share| quantile(&seen, share));
        let near = 2.0 * lower - upper..=2.0 * upper - lower;
        places.extend(finer.into_iter().filter(|(_, f)| !near.contains(f)));
        let (places, values): (Vec<_>, Vec<_>) = places.into_iter().unzip();
        let found = self.conditional()?.mean_of(&model.prior.equation, &places)?;
        let each = places.into_iter().zip(values).zip(found);
        Ok(each.map(|((at, value), u)| Candidate { at, value, residual: u - value }).collect())
    }

    /// The model with points of its equation where that is off most; none where its right-hand side is known at its points only, or
    /// there are enough of them.
    pub(super) fn with_more_points(&self, most: usize, round: u64) -> Result<Option<Model<D>>> {
        let model = self.model();
        let known = model.places();
        let room = most.saturating_sub(known.len());
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
        let ends: Vec<_> = (0..D).flat_map(|d| Side::BOTH.map(|side| (d, side))).collect();
        let tried = |(d, side): (usize, Side)| -> Result<(Self, HoldOut)> {
            let prior = prior.clone().stretched(&names[d], side, WIDTH * extents[d])?;
            let own = model.rebuilt(prior, model.given.clone())?;
            let fit = own.fit_from(vec![self.outcome().parameters.clone()], options.iterations)?;
            let error = fit.left_out()?;
            Ok((fit, error.unwrap_or_else(|| found.clone())))
        };
        let tried = in_parallel(ends, tried).into_iter().filter_map(Result::ok);
        // Next to nothing is off of an equation whose solution is next to nothing.
        let lost = |fit: &Self| fit.outcome().collapsed && !self.outcome().collapsed;
        let tried = tried.filter(|(fit, _)| !lost(fit));
        let error = |found: &HoldOut| found.residual / found.term;
        let best = tried.min_by(|a, b| error(&a.1).total_cmp(&error(&b.1)));
        let better = best.filter(|(_, own)| error(own) < LAYER * error(&found));
        Ok(better.unwrap_or((self, found)))
    }

    /// The fit with the error of collocation as noise of an equation that was exact, from the parameters before: so that
    /// intervals and bands are as much wider as the points leave open. As it was where that error is next to nothing.
    pub(super) fn with_equation_error(self, found: HoldOut, iterations: usize) -> Result<Self> {
        let model = self.model();
        let enough = if model.theta.is_empty() { RESOLVED } else { model.aim() };
        if found.residual <= enough * found.term {
            return Ok(Self { hold_out: Some(found), ..self });
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
