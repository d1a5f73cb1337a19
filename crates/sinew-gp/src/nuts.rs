//! The No-U-Turn sampler (Hoffman & Gelman 2014) over all parameters of a model, by the crate `nuts-rs`.
//!
//! The space is stretched by the curvature at the maximum, and each parameter's interval is opened up by
//! a logistic map, so that one step size serves all directions.

use crate::ensemble::Ensemble;
use crate::error::GpError;
use crate::fit::Fit;
use crate::space::Space;
use nuts_rs::{
    Chain, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError, Settings,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;

/// How parameters are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NutsOptions {
    /// Steps to find a step size, not kept.
    pub warmup: usize,
    /// Draws kept.
    pub draws: usize,
    /// Seed.
    pub seed: u64,
}

impl Default for NutsOptions {
    fn default() -> Self {
        Self { warmup: 150, draws: 300, seed: 0 }
    }
}

/// Draws parameters from their posterior, starting at its maximum.
///
/// # Errors
/// If the evidence cannot be evaluated at the fit.
#[doc(alias("MCMC", "HMC"))]
pub fn nuts<const D: usize>(fit: &Fit<D>, options: &NutsOptions) -> Result<Ensemble<D>, GpError> {
    let model = fit.model();
    let space = Space::new(model, &fit.outcome().parameters, true)?;
    let settings = DiagNutsSettings {
        num_tune: options.warmup as u64,
        num_draws: options.draws as u64,
        maxdepth: MOST_DOUBLINGS,
        ..DiagNutsSettings::default()
    };
    let mut random = ChaCha8Rng::seed_from_u64(options.seed);
    let start = vec![0.0; space.dimension()];
    let stopped = |error| GpError::Request(format!("NUTS cannot go on: {error:#}"));
    let density = CpuMath::new(Density(&space));
    let mut chain = settings.new_chain(0, density, &mut random).map_err(stopped)?;
    chain.set_position(&start).map_err(stopped)?;
    let mut draw = || Ok(space.parameters(&chain.draw().map_err(stopped)?.0));
    (0..options.warmup).try_for_each(|_| draw().map(|_| ()))?;
    let draws = (0..options.draws).map(|_| draw()).collect::<Result<_, GpError>>()?;
    Ensemble::checked(fit, draws, None)
}

/// Doublings of a trajectory at most.
const MOST_DOUBLINGS: u64 = 8;

/// The density that is sampled.
struct Density<'a, const D: usize>(&'a Space<'a, D>);

/// Error of a state at which the evidence has no value, which ends a trajectory.
#[derive(Debug, thiserror::Error)]
#[error("the evidence has no value")]
struct Undefined;

impl LogpError for Undefined {
    fn is_recoverable(&self) -> bool {
        true
    }
}

impl<const D: usize> HasDims for Density<'_, D> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".into(), self.0.dimension() as u64)])
    }
}

impl<const D: usize> CpuLogpFunc for Density<'_, D> {
    type LogpError = Undefined;
    type FlowParameters = ();
    type ExpandedVector = Vec<f64>;

    fn dim(&self) -> usize {
        self.0.dimension()
    }

    fn logp(&mut self, position: &[f64], gradient: &mut [f64]) -> Result<f64, Undefined> {
        let (value, slope) = self.0.log_density_and_slope(position);
        gradient.copy_from_slice(&slope);
        if value.is_finite() { Ok(value) } else { Err(Undefined) }
    }

    fn expand_vector<R: rand::Rng + ?Sized>(
        &mut self,
        _: &mut R,
        position: &[f64],
    ) -> Result<Vec<f64>, CpuMathError> {
        Ok(position.to_vec())
    }
}
