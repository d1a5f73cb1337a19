//! Draws of the parameters: about the fit, weighed by the posterior, and by the No-U-Turn sampler.
//!
//! The No-U-Turn sampler (Hoffman & Gelman 2014) over all parameters of a model, by `sinew-sample`.
//!
//! The space is stretched by the curvature at the maximum, and each parameter's interval is opened up by
//! a logistic map, so that one step size serves all directions.

use crate::posterior::ensemble::TRUSTED;
use crate::posterior::space::{Space, not_drawn};
use crate::{Ensemble, Fit, Result};
use nalgebra::DMatrix;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sinew_num::in_parallel;
use sinew_sample::{Chains, Laplace, nuts as chains, psis, split_seed, standard_normals};

/// Proposals for each draw that is kept.
const PROPOSALS: usize = 2;
/// Degrees of freedom of the proposals: tails heavier than any that the posterior is likely to have.
const FREEDOM: usize = 5;

/// Factor of the covariance that proposals move to: that of weights whose tail is smoothed is too small.
const INFLATION: f64 = 1.3;
/// Ratio of variances of draws to those of their proposals up to which proposals stay unchanged.
const ALIKE: f64 = 1.6;
/// Share of the covariance of proposals that is kept.
pub(crate) const LEAST: f64 = 1e-4;
/// Times that proposals are moved at most.
const ROUNDS: usize = 3;

/// Chains.
const CHAINS: usize = 4;
/// R̂ up to which chains agree; 1.01 takes more draws than an ensemble has (Vehtari et al. 2021).
const MIXED: f64 = 1.05;
/// Effective draws of bulk and tails, in units of the draws kept, from which on these suffice.
const EFFECTIVE: f64 = 0.33;
/// Times that chains are drawn anew at most, twice as long.
const CHAIN_ROUNDS: u64 = 1;

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

/// Draws parameters by importance: proposals from Student's t distribution with the curvature at the maximum of the
/// posterior (Laplace's approximation, with heavier tails; wider where the density falls more slowly than that), of which `draws`
/// are kept with the weight that the posterior has there over the proposals' (Kass & Raftery 1995, §4.2; weights
/// smoothed as by Vehtari et al. 2024). Where weights are heavy-tailed, or draws scatter unlike their proposals, these move to the mean and covariance of what they found and are drawn
/// again, three times at most (population Monte Carlo, Cappé et al. 2004); [`Ensemble::k_hat`] says how heavy they stay.
///
/// Weights of values ([`crate::Noise::StudentT`]) stay as fitted.
///
/// # Errors
/// If the evidence cannot be evaluated next to the fit.
#[doc(alias = "importance sampling")]
pub fn laplace<const D: usize>(fit: &Fit<D>, draws: usize, seed: u64) -> Result<Ensemble<D>> {
    instance!(D, Fit::weighed, Weighed<D>)(fit, draws, seed, true)
}

/// Draws by [`laplace`] where its weights can be trusted, else as many by [`crate::nuts`], whose chains start where that found mass.
///
/// # Errors
/// As these two.
pub fn ensemble<const D: usize>(fit: &Fit<D>, draws: usize, seed: u64) -> Result<Ensemble<D>> {
    instance!(D, Fit::weighed, Weighed<D>)(fit, draws, seed, false)
}

/// Draws parameters from their posterior in four chains, which start about its maximum. Chains that do not agree, or of too few
/// effective draws, are drawn anew with the covariance of what they found, twice as long.
///
/// # Errors
/// If the evidence cannot be evaluated at the fit.
#[doc(alias("MCMC", "HMC"))]
pub fn nuts<const D: usize>(fit: &Fit<D>, options: &NutsOptions) -> Result<Ensemble<D>> {
    instance!(D, Fit::chained, fn(&Fit<D>, &NutsOptions) -> Result<Ensemble<D>>)(fit, options)
}

type Weighed<const D: usize> = fn(&Fit<D>, usize, u64, bool) -> Result<Ensemble<D>>;

impl<const D: usize> Fit<D> {
    /// Draws by importance, `always` or where the weights can be trusted; else by chains.
    fn weighed(&self, draws: usize, seed: u64, always: bool) -> Result<Ensemble<D>> {
        let (model, fitted) = (self.model(), &self.outcome().parameters);
        let (space, mut proposals) = Space::new(model, fitted, model.without_weights())?;
        let first = proposals.clone();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        for round in 0.. {
            let drawn: Vec<_> =
                (0..PROPOSALS * draws).map(|_| propose(&proposals, &mut random)).collect();
            let ratio = |(q, own): &(Vec<f64>, f64)| space.log_density(q) - own;
            let ratios = in_parallel(&drawn, ratio);
            let smoothed = psis(&ratios, 1.0);
            let (weights, k_hat) = (smoothed.weights(), smoothed.k_hat);
            let (next, trusted) = (moved(&proposals, &drawn, &weights, LEAST), k_hat <= TRUSTED);
            let settled = trusted && next.as_ref().is_none_or(|next| alike(&proposals, next));
            if !settled && round < ROUNDS {
                proposals = next.unwrap_or(proposals);
                continue;
            }
            if always || trusted {
                let chosen = resample(&weights, draws, random.random());
                let draws = chosen.into_iter().map(|k| space.parameters(&drawn[k].0)).collect();
                return Ensemble::checked(self, draws, Some(k_hat), None);
            }
            let options = NutsOptions { draws, seed, ..NutsOptions::default() };
            // Weights of values are drawn too.
            if model.without_weights() < model.parameters().len() {
                return nuts(self, &options);
            }
            // A chain begins with the width of both.
            let about = moved(&first, &drawn, &weights, 1.0).unwrap_or(first);
            return sampled(self, &space, about, &options);
        }
        unreachable!("the last round returns")
    }

    fn chained(&self, options: &NutsOptions) -> Result<Ensemble<D>> {
        let model = self.model();
        let count = model.parameters().len();
        let (space, about) = Space::new(model, &self.outcome().parameters, count)?;
        sampled(self, &space, about, options)
    }
}

/// A variate of the multivariate t distribution about a mode and the logarithm of its density, up to a constant.
fn propose(about: &Laplace, random: &mut ChaCha8Rng) -> (Vec<f64>, f64) {
    let freedom = FREEDOM as f64;
    let square = |z: &[f64]| z.iter().map(|z| z * z).sum::<f64>();
    let stretch = (freedom / square(&standard_normals(FREEDOM, random))).sqrt();
    let mut t = standard_normals(about.dimension(), random);
    t.iter_mut().for_each(|t| *t *= stretch);
    let power = 0.5 * (freedom + t.len() as f64);
    (about.point(&t), -power * (square(&t) / freedom).ln_1p())
}

/// Whether variances of one are about those of the other: a spike may have light weights under proposals as narrow as it is.
fn alike(a: &Laplace, b: &Laplace) -> bool {
    let ratio = b.covariance().diagonal().component_div(&a.covariance().diagonal()) / INFLATION;
    ratio.iter().all(|ratio| (ALIKE.recip()..=ALIKE).contains(ratio))
}

/// The mean of draws with weights whose sum is 1, and their covariance with a share `least` of that before; none where these have none.
pub(crate) fn moved(
    about: &Laplace,
    drawn: &[(Vec<f64>, f64)],
    weights: &[f64],
    least: f64,
) -> Option<Laplace> {
    let dimension = about.dimension();
    let average = |of: &dyn Fn(&[f64]) -> f64| -> f64 {
        drawn.iter().zip(weights).map(|((q, _), weight)| weight * of(q)).sum()
    };
    let centre: Vec<f64> = (0..dimension).map(|k| average(&|q| q[k])).collect();
    let known = about.covariance();
    let covariance = DMatrix::from_fn(dimension, dimension, |i, j| {
        let product = average(&|q| (q[i] - centre[i]) * (q[j] - centre[j]));
        INFLATION * product + least * known[(i, j)]
    });
    Laplace::from_covariance(&centre, covariance).ok()
}

/// Positions drawn with these weights, whose sum is 1, ascending: systematic resampling, from one uniform number.
fn resample(weights: &[f64], count: usize, uniform: f64) -> Vec<usize> {
    let (mut chosen, mut sum) = (Vec::with_capacity(count), 0.0);
    for (number, weight) in weights.iter().enumerate() {
        sum += weight * count as f64;
        while chosen.len() < count && chosen.len() as f64 + uniform < sum {
            chosen.push(number);
        }
    }
    chosen
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
        if !doubtful || round == CHAIN_ROUNDS {
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
