//! Parameters of the equation that the data do not tell.

use crate::evidence::state::State;
use crate::fit::optimise::maximise;
use crate::{Fit, Model, Result, Warning};
use sinew_num::ascending;

/// Standard deviation in units of that of the prior from which on a parameter has not contracted.
const WIDE: f64 = 0.5;
/// Such a deviation of a posterior that reaches a bound, so that data tell one side only.
const WIDE_AT_BOUND: f64 = 0.25;
/// Share of a range at its end, and least share of a posterior there that has reached it: two fifths of a prior's.
const END: f64 = 0.05;
const REACHED: f64 = 0.02;
/// Values of a parameter in its profile, and iterations for each.
const VALUES: usize = 20;
const ITERATIONS: usize = 100;
/// Decrease of the logarithm of the probability of the data beyond which a profile ends.
const FAR: f64 = 10.0;

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
                profile.push((at.clone(), log.min(FAR).exp()));
                if log < -FAR {
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
        let near = |end: f64| mean(&|x| f64::from(u8::from((x - end).abs() < END)));
        let centre = mean(&|x| x);
        let deviation = (12.0 * mean(&|x| (x - centre).powi(2))).sqrt();
        (deviation, near(0.0).max(near(1.0)) > REACHED)
    }

    /// Warning of a parameter that the data do not tell.
    pub(crate) fn unidentified(&self, k: usize) -> Warning {
        Warning::Unidentified { parameter: self.parameters[k].name.clone() }
    }
}
