//! Parameters of the equation that the data do not tell.

use crate::error::Result;
use crate::fit::Fit;
use crate::state::State;

/// Standard deviation in units of that of the prior from which on a parameter has not contracted.
const WIDE: f64 = 0.5;
/// Such a deviation of a posterior that reaches a bound, so that data tell one side only.
const WIDE_AT_BOUND: f64 = 0.25;
/// Share of a range within which draws have reached its end, where of a prior as many lie there.
const END: f64 = 0.05;
/// Values of a parameter at which the data's probability is looked at.
const VALUES: usize = 12;

impl<const D: usize> Fit<D> {
    /// Positions of parameters that the data do not tell: of which draws are about as wide as the prior, or on which the probability of
    /// the data does not depend, whatever the draws.
    pub(crate) fn unidentified(&self, draws: &[Vec<f64>]) -> Result<Vec<usize>> {
        let (model, bounds) = (self.model(), self.model().scaled_bounds());
        let mut found = Vec::new();
        for k in model.theta_range() {
            let [lower, upper] = bounds[k];
            let share = |x: f64| (x - lower) / (upper - lower);
            let drawn: Vec<(f64, f64)> = draws.iter().map(|draw| (share(draw[k]), 1.0)).collect();
            let near = |end: f64| drawn.iter().filter(|(s, _)| (s - end).abs() < END).count();
            let reached = near(0.0).max(near(1.0)) as f64 > END * draws.len() as f64;
            let wide = if reached { WIDE_AT_BOUND } else { WIDE };
            if deviation(&drawn) > wide || deviation(&self.probable(k, [lower, upper])?) > WIDE {
                found.push(k);
            }
        }
        Ok(found)
    }

    /// Shares of the range of a parameter with the probability of the data there, up to a factor; all others stay as fitted.
    fn probable(&self, k: usize, [lower, upper]: [f64; 2]) -> Result<Vec<(f64, f64)>> {
        let mut at = self.outcome().parameters.clone();
        let mut logs = Vec::with_capacity(VALUES);
        for value in 0..VALUES {
            let share = (value as f64 + 0.5) / VALUES as f64;
            at[k] = lower + share * (upper - lower);
            let state = State::new(self.model(), &at)?;
            let log = state.factored().map_or(f64::NEG_INFINITY, |own| state.in_full(&own));
            logs.push((share, log));
        }
        let most = logs.iter().fold(f64::NEG_INFINITY, |most, (_, log)| most.max(*log));
        Ok(logs.into_iter().map(|(share, log)| (share, (log - most).exp())).collect())
    }
}

/// Standard deviation of numbers with weights, in units of that of even ones between 0 and 1.
fn deviation(weighted: &[(f64, f64)]) -> f64 {
    let sum = |of: &dyn Fn(f64) -> f64| weighted.iter().map(|(x, w)| w * of(*x)).sum::<f64>();
    let (whole, mean) = (sum(&|_| 1.0), sum(&|x| x) / sum(&|_| 1.0));
    (12.0 * sum(&|x| (x - mean).powi(2)) / whole).sqrt()
}
