//! Correction of an emulator's draws by the solver: importance ratios, and one sweep of independence Metropolis.

use crate::fault::Result;
use crate::likelihood::Target;
use crate::{Correction, Observed, Solves};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_sample::{Chains, effective_share, psis, quantile, split_seed};

/// Largest Pareto k̂ of a posterior that counts as confirmed (Vehtari et al. 2024: below it means have the usual error).
pub(crate) const MOST_K: f64 = 0.5;
/// Largest k̂ of a few draws at which all draws are solved. From few draws k̂ scatters by 0.1 to 0.2.
const MOST_K_OF_FEW: f64 = 0.7;
/// Least effective share.
pub(crate) const LEAST_SHARE: f64 = 0.5;
/// Error of the emulator \[standard deviations of the datum\] above which another round follows.
const MOST_ERROR: f64 = 0.1;
/// Share of draws whose error counts: tails hold the rest.
const ERROR_SHARE: f64 = 0.95;
/// Range of the log weights below which k̂ is 0: no weight dominates a mean then.
const EQUAL: f64 = 0.1;
/// Seed stream of the sweep.
const SWEEP: u64 = 0x5357;

/// Draws with the solver's observables and log ratios.
pub(crate) struct Verified {
    pub draws: Chains,
    /// Solver's observables by chain and draw; none where it has no answer.
    pub observed: Vec<Vec<Option<Observed>>>,
    /// Logarithms of solver's over emulator's likelihood, by chain.
    pub ratios: Vec<Vec<f64>>,
    pub correction: Correction,
}

impl Verified {
    /// Solves at draws of the emulator's posterior and compares.
    pub(crate) fn new(
        target: &Target,
        solves: &mut Solves,
        stage: &str,
        draws: Chains,
    ) -> Result<Self> {
        let problem = target.problem;
        let thetas: Vec<_> = draws.pooled().map(|y| problem.theta(y)).collect();
        let answers = solves.at(stage, &thetas, false)?;
        let found: Vec<Option<Observed>> = answers.into_iter().map(Result::ok).collect();
        let ratio = |(y, observed): (&Vec<f64>, &Option<Observed>)| match observed {
            Some(observed) => problem.log_likelihood(y, observed) - target.log_likelihood(y),
            None => f64::NEG_INFINITY,
        };
        let all: Vec<f64> = draws.pooled().zip(&found).map(ratio).collect();
        let (largest_error, worst) = largest_error(target, &draws, &found);
        let correction = Correction {
            k_hat: k_hat(&all),
            share: effective_share(&all),
            largest_error,
            worst_datum: problem.data[worst].name.clone(),
            degree: target.emulator.degree,
            ..Correction::default()
        };
        let per_chain = draws.draws.first().map_or(1, Vec::len).max(1);
        let ratios = all.chunks(per_chain).map(<[f64]>::to_vec).collect();
        let observed = found.chunks(per_chain).map(<[_]>::to_vec).collect();
        Ok(Self { draws, observed, ratios, correction })
    }

    /// Whether importance sampling gives the solver's posterior from these draws.
    pub(crate) fn is_confirmed(&self) -> bool {
        self.correction.k_hat <= MOST_K && self.correction.share >= LEAST_SHARE
    }

    /// Whether these few draws justify solving all. The last round does not require accuracy, since the weights correct the
    /// error.
    pub(crate) fn is_promising(&self, last: bool) -> bool {
        let Correction { k_hat, share, largest_error, .. } = self.correction;
        let accurate = last || largest_error <= MOST_ERROR;
        k_hat <= MOST_K_OF_FEW && share >= LEAST_SHARE && accurate
    }

    /// Equally weighted draws of the solver's posterior by independence Metropolis over the draws of each chain (Tierney 1994),
    /// started from a draw by its weight: coordinates with observables, and the share of proposals that were accepted.
    pub(crate) fn sweep(&self, seed: u64) -> ([Chains; 2], f64) {
        let mut random = ChaCha8Rng::seed_from_u64(split_seed(seed, SWEEP));
        let (mut swept, mut seen, mut accepted, mut proposed) = (Vec::new(), Vec::new(), 0, 0);
        for (chain, ratios) in self.ratios.iter().enumerate() {
            let mut now = pick(ratios, random.random());
            let mut kept = Vec::with_capacity(ratios.len());
            for next in 0..ratios.len() {
                let uniform: f64 = random.random();
                proposed += 1;
                if uniform.ln() < ratios[next] - ratios[now] {
                    now = next;
                    accepted += 1;
                }
                kept.push(now);
            }
            swept.push(kept.iter().map(|&at| self.draws.draws[chain][at].clone()).collect());
            let of = |&at: &usize| Some(self.observed[chain][at].as_ref()?.values.clone());
            seen.push(kept.iter().filter_map(of).collect());
        }
        let chains = [swept, seen].map(|draws| Chains { draws });
        (chains, f64::from(accepted) / f64::from(proposed.max(1)))
    }
}

/// Place drawn with weights of these logarithms.
fn pick(ratios: &[f64], uniform: f64) -> usize {
    let most = ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = ratios.iter().map(|r| (r - most).exp()).collect();
    let mut left = uniform * weights.iter().sum::<f64>();
    let drawn = weights.iter().position(|weight| {
        left -= weight;
        left < 0.0
    });
    drawn.unwrap_or_else(|| ratios.iter().position(|r| *r == most).unwrap_or(0))
}

/// Pareto k̂, and 0 where the weights hardly differ.
fn k_hat(ratios: &[f64]) -> f64 {
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let most = ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if most - least < EQUAL { 0.0 } else { psis(ratios, 1.0).k_hat }
}

fn largest_error(target: &Target, draws: &Chains, found: &[Option<Observed>]) -> (f64, usize) {
    let errors = |(y, observed): (&Vec<f64>, &Option<Observed>)| {
        let error = target.problem.scaled(&observed.as_ref()?.values) - target.predicted(y);
        Some(error.abs())
    };
    let errors: Vec<_> = draws.pooled().zip(found).filter_map(errors).collect();
    let of = |datum: usize| {
        quantile(&errors.iter().map(|draw| draw[datum]).collect::<Vec<_>>(), ERROR_SHARE)
    };
    let all = (0..target.problem.data.len()).map(|datum| (of(datum), datum));
    all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::NAN, 0))
}
