//! The No-U-Turn sampler (Hoffman and Gelman, 2014) by the crate `nuts-rs`, in chains that do not depend on threads.

use crate::error::SampleError;
use crate::{Chains, Laplace, LogDensity, split_seed, standard_normals};
use nuts_rs::{
    Chain, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError, Settings,
};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::ControlFlow;

/// Options of the sampling of a density.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NutsOptions {
    /// Chains.
    pub chains: usize,
    /// Steps of each chain that adapt and are not kept.
    pub warmup: usize,
    /// Draws of each chain that are kept.
    pub draws: usize,
    /// Seed of all chains.
    pub seed: u64,
}

impl Default for NutsOptions {
    fn default() -> Self {
        Self { chains: 4, warmup: 400, draws: 1000, seed: 0 }
    }
}

/// Doublings of a trajectory at most.
const MOST_DOUBLINGS: u64 = 10;
/// Halvings of the distance to the mode in search of a start inside the domain.
const HALVINGS: usize = 20;

/// Draws from a density in coordinates whitened by `about`; chains start at draws of it. The same seed gives the same draws on
/// any number of threads.
///
/// # Errors
/// A density that is not finite at the mode.
pub fn nuts(
    density: &dyn LogDensity,
    about: &Laplace,
    options: &NutsOptions,
) -> Result<Chains, SampleError> {
    nuts_from(density, about, &[], options, &|| ControlFlow::Continue(()))
}

/// [`nuts`] with chains that start at draws of `about`, moved to given points in turn; at its mode if there are none. `told` is called
/// after each step of a chain, and may end the sampling.
///
/// # Errors
/// A density that is not finite at a start; a `told` that breaks.
pub fn nuts_from(
    density: &dyn LogDensity,
    about: &Laplace,
    starts: &[Vec<f64>],
    options: &NutsOptions,
    told: &(dyn Fn() -> ControlFlow<()> + Sync),
) -> Result<Chains, SampleError> {
    let one = |number: usize| {
        let seed = split_seed(options.seed, number as u64);
        let start = if starts.is_empty() { about.mode() } else { &starts[number % starts.len()] };
        let about = about.moved_to(start);
        let whitened = Whitened { density, about: &about, gradient: vec![0.0; start.len()] };
        chain(whitened, number, seed, options, told)
    };
    let draws = (0..options.chains).into_par_iter().map(one).collect::<Result<_, _>>()?;
    Ok(Chains { draws })
}

fn chain(
    mut whitened: Whitened,
    number: usize,
    seed: u64,
    options: &NutsOptions,
    told: &(dyn Fn() -> ControlFlow<()> + Sync),
) -> Result<Vec<Vec<f64>>, SampleError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let z = standard_normals(whitened.dim(), &mut random);
    let start = whitened.start(z).ok_or_else(|| {
        SampleError(format!("the density is not finite at the start of chain {number}; start from a point inside its domain"))
    })?;
    let about = whitened.about;
    let settings = DiagNutsSettings {
        num_tune: options.warmup as u64,
        num_draws: options.draws as u64,
        maxdepth: MOST_DOUBLINGS,
        ..DiagNutsSettings::default()
    };
    let stopped = |why| SampleError(format!("the No-U-Turn sampler cannot go on: {why:#}"));
    let mut chain =
        settings.new_chain(number as u64, CpuMath::new(whitened), &mut random).map_err(stopped)?;
    chain.set_position(&start).map_err(stopped)?;
    let mut draw = || {
        let (z, _) = chain.draw().map_err(stopped)?;
        let fault = "the No-U-Turn sampler cannot go on: it was interrupted";
        let point = told().is_continue().then(|| about.point(&z));
        point.ok_or_else(|| SampleError(fault.into()))
    };
    for _ in 0..options.warmup {
        draw()?;
    }
    (0..options.draws).map(|_| draw()).collect()
}

/// A density in whitened coordinates.
struct Whitened<'a> {
    density: &'a dyn LogDensity,
    about: &'a Laplace,
    gradient: Vec<f64>,
}

impl Whitened<'_> {
    /// The nearest of z, z/2, z/4, … to start from.
    fn start(&mut self, mut z: Vec<f64>) -> Option<Vec<f64>> {
        let mut gradient = vec![0.0; z.len()];
        for _ in 0..HALVINGS {
            if self.logp(&z, &mut gradient).is_ok() {
                return Some(z);
            }
            z.iter_mut().for_each(|z| *z *= 0.5);
        }
        None
    }
}

/// A state outside the domain, which ends a trajectory.
#[derive(Debug, thiserror::Error)]
#[error("the density is zero")]
struct Outside;

impl LogpError for Outside {
    fn is_recoverable(&self) -> bool {
        true
    }
}

impl HasDims for Whitened<'_> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".into(), self.about.dimension() as u64)])
    }
}

impl CpuLogpFunc for Whitened<'_> {
    type LogpError = Outside;
    type FlowParameters = ();
    type ExpandedVector = Vec<f64>;

    fn dim(&self) -> usize {
        self.about.dimension()
    }

    fn logp(&mut self, position: &[f64], gradient: &mut [f64]) -> Result<f64, Outside> {
        let point = self.about.point(position);
        let value = self.density.value_and_gradient(&point, &mut self.gradient);
        let inside = value.is_finite() && self.gradient.iter().all(|g| g.is_finite());
        if !inside {
            return Err(Outside);
        }
        gradient.copy_from_slice(&self.about.pull_back(&self.gradient));
        Ok(value)
    }

    fn expand_vector<R: rand::Rng + ?Sized>(
        &mut self,
        _: &mut R,
        position: &[f64],
    ) -> Result<Vec<f64>, CpuMathError> {
        Ok(position.to_vec())
    }
}
