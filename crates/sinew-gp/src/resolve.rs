//! How many collocation points: more of them until the answer no longer moves.

use crate::data::{Data, Noise};
use crate::domain::Domain;
use crate::error::GpError;
use crate::field::Field;
use crate::fit::{Fit, FitOptions};
use crate::laplace::laplace;
use crate::model::Model;
use std::sync::Arc;

/// An equation that holds everywhere, and what else there is.
#[derive(Clone, Debug)]
pub(crate) struct Everywhere<const D: usize> {
    pub source: Field<D>,
    pub rest: Data<D>,
}

/// Points that an equation begins with, for each dimension.
const FIRST: usize = 15;
/// Factor from one number of points to the next.
const GROWTH: f64 = 1.6;
/// Share of an interval's width that its ends and the estimate may move by: twice what 400 draws leave open.
const MOVE: f64 = 0.15;
const DRAWS: usize = 400;
/// Of u, where no parameter of the equation is sought, relative to its largest value.
const MOVE_OF_U: f64 = 1e-3;
/// Seeds of places: of the equation, where u is compared, of draws.
const SEEDS: [u64; 3] = [0x5eed, 0x100c, 0xd4a3];

impl<const D: usize> Everywhere<D> {
    /// All data, with the equation at `count` points: the first of a sequence that does not depend on their number.
    pub(crate) fn at(&self, domain: &Domain<D>, count: usize) -> Result<Data<D>, GpError> {
        let at = domain.sample(count, SEEDS[0])?;
        let f: Vec<f64> = at.iter().map(|x| self.source.value(*x)).collect();
        Ok(self.rest.clone().equation(&at, &f, Noise::Exact))
    }

    pub(crate) fn first() -> usize {
        FIRST * D
    }
}

/// What is watched while points are added.
struct Watched {
    /// For each parameter of the equation, on its scale: lower end, estimate, upper end.
    intervals: Vec<[f64; 3]>,
    u: Vec<f64>,
}

impl Watched {
    fn of<const D: usize>(fit: &Fit<D>) -> Result<Self, GpError> {
        let model = fit.model();
        let theta = model.theta_offset..model.theta_offset + model.theta.len();
        let mut intervals = Vec::new();
        if !theta.is_empty() {
            let ensemble = laplace(fit, DRAWS, SEEDS[2])?;
            for parameter in &model.parameters[theta] {
                let [lower, upper] = ensemble.interval(&parameter.name, 0.95)?;
                let all = [lower, fit.parameter(&parameter.name)?, upper];
                intervals.push(all.map(|value| parameter.to_scale(value)));
            }
        }
        let places = model.prior.domain.sample(50, SEEDS[1])?;
        Ok(Self { intervals, u: fit.posterior()?.mean(&places)? })
    }

    fn has_settled(&self, before: &Self) -> bool {
        if self.intervals.is_empty() {
            let size = self.u.iter().fold(f64::MIN_POSITIVE, |most, u| most.max(u.abs()));
            let moved = self.u.iter().zip(&before.u).map(|(a, b)| (a - b).abs());
            return moved.fold(0.0, f64::max) <= MOVE_OF_U * size;
        }
        self.intervals.iter().zip(&before.intervals).all(|(now, before)| {
            let width = now[2] - now[0];
            now.iter().zip(before).all(|(a, b)| (a - b).abs() <= MOVE * width)
        })
    }
}

/// Refits with more and more points, from the parameters before, until nothing moves.
pub(crate) fn resolve<const D: usize>(
    mut fit: Fit<D>,
    options: &FitOptions,
) -> Result<Fit<D>, GpError> {
    let Some(everywhere) = fit.model().everywhere.clone() else { return Ok(fit) };
    let mut count = Everywhere::<D>::first();
    let mut before = Watched::of(&fit)?;
    loop {
        let more = ((count as f64 * GROWTH) as usize).min(options.most_points);
        if more <= count {
            fit.unsettled = Some(count);
            return Ok(fit);
        }
        count = more;
        let start = fit.outcome().parameters.clone();
        let old = fit.into_model();
        let asked = old.evidence;
        let data = everywhere.at(&old.prior.domain, count)?;
        let mut model = Model::new(old.prior, data, asked)?;
        model.everywhere = Some(everywhere.clone());
        let mut starts = model.random_starts(options);
        starts.truncate(options.restarts.saturating_sub(1));
        starts.push(start);
        fit = model.fit_from(starts, options.iterations)?;
        let now = Watched::of(&fit)?;
        if now.has_settled(&before) {
            fit.unsettled = None;
            return Ok(fit);
        }
        before = now;
    }
}

impl<const D: usize> Fit<D> {
    /// The model again, which no one else holds while points are added.
    fn into_model(self) -> Model<D> {
        Arc::into_inner(self.model).expect("a fit in the making is shared with no one")
    }
}
