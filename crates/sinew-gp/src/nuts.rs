//! The No-U-Turn sampler (Hoffman & Gelman 2014) over all parameters of a model, by `sinew-sample`.
//!
//! The space is stretched by the curvature at the maximum, and each parameter's interval is opened up by
//! a logistic map, so that one step size serves all directions.

use crate::ensemble::Ensemble;
use crate::error::Result;
use crate::fit::Fit;
use crate::instances::instance;
use crate::space::{Space, not_drawn};
use sinew_sample::{Summary, nuts as chains};

/// Options of the sampling of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NutsOptions {
    /// Steps of each of two chains to find a step size, not kept.
    pub warmup: usize,
    /// Draws kept, half of them of each chain.
    pub draws: usize,
    /// Seed.
    pub seed: u64,
}

impl Default for NutsOptions {
    fn default() -> Self {
        Self { warmup: 100, draws: 300, seed: 0 }
    }
}

/// Chains: the fewest that can be told to agree.
const CHAINS: usize = 2;

/// Draws parameters from their posterior in two chains, which start about its maximum.
///
/// # Errors
/// If the evidence cannot be evaluated at the fit.
#[doc(alias("MCMC", "HMC"))]
pub fn nuts<const D: usize>(fit: &Fit<D>, options: &NutsOptions) -> Result<Ensemble<D>> {
    instance!(D, sampled, fn(&Fit<D>, &NutsOptions) -> Result<Ensemble<D>>)(fit, options)
}

fn sampled<const D: usize>(fit: &Fit<D>, options: &NutsOptions) -> Result<Ensemble<D>> {
    let model = fit.model();
    let count = model.parameters().len();
    let (space, about) = Space::new(model, &fit.outcome().parameters, count)?;
    let NutsOptions { warmup, draws, seed } = *options;
    let own =
        sinew_sample::NutsOptions { chains: CHAINS, warmup, draws: draws.div_ceil(CHAINS), seed };
    let found = chains(&space, &about, &own).map_err(not_drawn)?;
    let r_hats = (0..model.theta.len())
        .map(|k| (k, Summary::of(&found.parameter(model.theta_offset + k)).r_hat));
    let worst = r_hats.max_by(|a, b| a.1.total_cmp(&b.1));
    let draws = found.pooled().map(|q| space.parameters(q)).take(draws).collect();
    Ensemble::checked(fit, draws, None, worst)
}
