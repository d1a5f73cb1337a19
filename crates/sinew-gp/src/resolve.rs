//! How many collocation points: more of them until the answer no longer moves.

use crate::error::GpError;
use crate::everywhere::Everywhere;
use crate::fit::{Fit, FitOptions};
use crate::laplace::laplace;
use crate::model::Model;
use std::sync::Arc;

/// Factor from one number of points to the next.
const GROWTH: f64 = 1.6;
/// Share of an interval's width that its ends and the estimate may move by: twice what 400 draws leave open.
const MOVE: f64 = 0.15;
const DRAWS: usize = 400;
/// Accuracy of u, where no parameter of the equation is sought, relative to its largest value.
const MOVE_OF_U: f64 = 1e-3;
/// Seeds of the places where u is compared, and of draws.
const SEEDS: [u64; 2] = [0x100c, 0xd4a3];

/// Quantities watched while points are added.
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
            let ensemble = laplace(fit, DRAWS, SEEDS[1])?;
            for parameter in &model.parameters[theta] {
                let [lower, upper] = ensemble.interval(&parameter.name, 0.95)?;
                let all = [lower, fit.parameter(&parameter.name)?, upper];
                intervals.push(all.map(|value| parameter.to_scale(value)));
            }
        }
        let places = model.prior.domain.sample(50, SEEDS[0])?;
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

impl<const D: usize> Model<D> {
    /// Maximises evidence times [`crate::Hyperprior`]s from random starts, in parallel.
    ///
    /// The best restart that did not collapse is taken, or the best if all did.
    ///
    /// # Errors
    /// If no restart has a finite evidence.
    pub fn fit(self, options: &FitOptions) -> Result<Fit<D>, GpError> {
        let starts = self.random_starts(options);
        resolve(self.fit_from(starts, options.iterations)?, options)
    }
}

/// Refits with more and more points, from the parameters before, until nothing moves.
fn resolve<const D: usize>(mut fit: Fit<D>, options: &FitOptions) -> Result<Fit<D>, GpError> {
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
