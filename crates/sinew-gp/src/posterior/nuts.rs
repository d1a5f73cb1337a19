//! The No-U-Turn sampler (Hoffman & Gelman 2014) over all parameters of a model, by `sinew-sample`.
//!
//! The space is stretched by the curvature at the maximum, and each parameter's interval is opened up by
//! a logistic map, so that one step size serves all directions.

use crate::posterior::laplace::{LEAST, moved};
use crate::posterior::space::{Space, not_drawn};
use crate::{Ensemble, Fit, Result};
use sinew_sample::{Chains, Laplace, nuts as chains, split_seed};

/// Options of the sampling of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NutsOptions {
    /// Steps of each of four chains to find a step size, not kept.
    pub warmup: usize,
    /// Draws kept, a quarter of them of each chain.
    pub draws: usize,
    /// Seed.
    pub seed: u64,
}

impl Default for NutsOptions {
    fn default() -> Self {
        Self { warmup: 100, draws: 300, seed: 0 }
    }
}

/// Chains.
const CHAINS: usize = 4;
/// R̂ up to which chains agree; 1.01 takes more draws than an ensemble has (Vehtari et al. 2021).
const MIXED: f64 = 1.05;
/// Effective draws of bulk and tails, in units of the draws kept, from which on these suffice.
const EFFECTIVE: f64 = 0.33;
/// Times that chains are drawn anew at most, twice as long.
const ROUNDS: u64 = 1;

/// Draws parameters from their posterior in four chains, which start about its maximum. Chains that do not agree, or of too few
/// effective draws, are drawn anew with the covariance of what they found, twice as long.
///
/// # Errors
/// If the evidence cannot be evaluated at the fit.
#[doc(alias("MCMC", "HMC"))]
pub fn nuts<const D: usize>(fit: &Fit<D>, options: &NutsOptions) -> Result<Ensemble<D>> {
    instance!(D, Fit::chained, fn(&Fit<D>, &NutsOptions) -> Result<Ensemble<D>>)(fit, options)
}

impl<const D: usize> Fit<D> {
    fn chained(&self, options: &NutsOptions) -> Result<Ensemble<D>> {
        let model = self.model();
        let count = model.parameters().len();
        let (space, about) = Space::new(model, &self.outcome().parameters, count)?;
        sampled(self, &space, about, options)
    }
}

/// [`nuts`] in a space, with chains that start about a mode.
pub(crate) fn sampled<const D: usize>(
    fit: &Fit<D>,
    space: &Space<'_, D>,
    mut about: Laplace,
    &NutsOptions { warmup, draws, seed }: &NutsOptions,
) -> Result<Ensemble<D>> {
    let kept = draws.div_ceil(CHAINS);
    for round in 0.. {
        let own = sinew_sample::NutsOptions {
            chains: CHAINS,
            warmup: warmup << round,
            draws: kept << round,
            seed: if round == 0 { seed } else { split_seed(seed, round) },
        };
        let found = chains(space, &about, &own).map_err(not_drawn)?;
        let worst = least_mixed(fit, &found)?;
        let doubtful = worst.is_some_and(|(_, r_hat, effective)| {
            r_hat > MIXED || effective < EFFECTIVE * draws as f64
        });
        if !doubtful || round == ROUNDS {
            let all = found.thinned(kept);
            let draws = all.pooled().map(|q| space.parameters(q)).take(draws).collect();
            return Ensemble::checked(fit, draws, None, worst.filter(|_| doubtful));
        }
        let all: Vec<_> = found.pooled().map(|q| (q.clone(), 0.0)).collect();
        let weights = vec![1.0 / all.len() as f64; all.len()];
        about = moved(&about, &all, &weights, LEAST).unwrap_or(about);
    }
    unreachable!("the last round returns")
}

/// Parameter of the equation with the fewest effective draws, R̂ and number of these, of those that the data tell; none of chains
/// too short to say.
fn least_mixed<const D: usize>(fit: &Fit<D>, found: &Chains) -> Result<Option<(usize, f64, f64)>> {
    let silent = fit.silent()?;
    let of = |k: usize| {
        let summary = found.summary(k);
        (k, summary.r_hat, summary.ess_bulk.min(summary.ess_tail))
    };
    let all = fit.model().theta_range().filter(|k| !silent.contains(k)).map(of);
    Ok(all.filter(|(_, r_hat, _)| r_hat.is_finite()).min_by(|a, b| a.2.total_cmp(&b.2)))
}
