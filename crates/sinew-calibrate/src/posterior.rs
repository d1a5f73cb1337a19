//! The result: the solver's correction of an emulator's draws (importance ratios, and one sweep of independence Metropolis), and what they say.

use crate::fault::Result;
use crate::likelihood::Target;
use crate::problem::FACTOR_DEVIATION;
use crate::{Correction, Identifiability, Identified, Mode, Observed, Predictive, Problem, Solves};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use sinew_sample::{
    ArvizDict, Chains, SampleError, Summary, effective_share, psis, quantile, split_seed,
    standard_normals, write_csv,
};
use std::path::Path;

/// Seed streams of draws that are written beside the posterior.
const PRIOR: u64 = 0x5052;
const REPLICATES: u64 = 0x5245;

/// Equally weighted draws of the solver's posterior.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// Parameters and data.
    pub problem: Problem,
    /// The mode.
    pub mode: Mode,
    /// Coordinates whose prior is standard normal, by chain and draw.
    pub coordinates: Chains,
    /// Parameters in the unit of [`crate::Forward`], then factors of inferred noise, by chain and draw.
    pub draws: Chains,
    /// The solver's observables in their own units, by chain and draw.
    pub observed: Chains,
    /// Parameters and directions that data identify, linearised at the mode.
    pub identifiability: Identifiability,
    /// Data beside their predictions.
    pub predictive: Predictive,
    /// Error of the emulator, and the cost.
    pub correction: Correction,
    seed: u64,
}

impl Posterior {
    pub(crate) fn new(
        problem: &Problem,
        mode: &Mode,
        verified: &Verified,
        correction: Correction,
        seed: u64,
    ) -> Self {
        let ([coordinates, observed], acceptance) = verified.sweep(seed);
        let theta = |y: &[f64]| {
            let factors = problem.log_factors(y).into_iter().map(f64::exp);
            problem.theta(y).into_iter().chain(factors).collect()
        };
        let pairs = coordinates.pooled().zip(observed.pooled());
        let pairs: Vec<_> = pairs.map(|(y, o)| (y.as_slice(), o.as_slice())).collect();
        Self {
            identifiability: Identifiability::new(problem, mode),
            predictive: Predictive::new(problem, &pairs),
            correction: Correction { acceptance, ..correction },
            problem: problem.clone(),
            mode: mode.clone(),
            draws: coordinates.mapped(theta),
            coordinates,
            observed,
            seed,
        }
    }

    /// Names with units of what was drawn: parameters, then factors of inferred noise.
    pub fn heads(&self) -> Vec<String> {
        let unknowns = self.problem.unknowns.iter().map(|unknown| unknown.head());
        let kinds = self.problem.inferred_kinds().map(|kind| format!("noise factor of {kind}"));
        unknowns.chain(kinds).collect()
    }

    /// Draws of one parameter or factor in the unit that people read, by chain.
    pub fn shown(&self, index: usize) -> Vec<Vec<f64>> {
        let size = self.problem.unknowns.get(index).map_or(1.0, |unknown| unknown.size);
        let mut chains = self.draws.parameter(index);
        chains.iter_mut().flatten().for_each(|value| *value /= size);
        chains
    }

    /// Summary of one parameter or factor in the unit that people read.
    pub fn summary(&self, index: usize) -> Summary {
        Summary::of(&self.shown(index))
    }

    /// Logarithm of the likelihood by chain, draw and datum, for leave-one-out comparisons of models. Of data that share errors it is that of
    /// each given the others (Bürkner, Gabry and Vehtari, Computational Statistics, 2021).
    pub fn log_likelihood(&self) -> Vec<Vec<Vec<f64>>> {
        let chains = self.coordinates.draws.iter().zip(&self.observed.draws);
        let one = |(y, seen): (&Vec<f64>, &Vec<f64>)| self.problem.log_likelihoods(y, seen);
        chains.map(|(draws, seen)| draws.iter().zip(seen).map(one).collect()).collect()
    }

    /// Posterior over prior standard deviation of the logarithm of a parameter.
    pub fn contraction(&self, parameter: usize) -> f64 {
        let mut chains = self.draws.parameter(parameter);
        chains.iter_mut().flatten().for_each(|value| *value = value.ln());
        Summary::of(&chains).deviation / self.problem.unknowns[parameter].prior.moments()[1]
    }

    /// Whether data identify a parameter.
    #[doc(alias = "decided")]
    pub fn identified(&self, parameter: usize) -> Identified {
        Identified::of(self.contraction(parameter))
    }

    /// Writes the draws of parameters and factors as a table.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_csv(&self, path: &Path) -> Result<(), SampleError> {
        let columns = self.heads().into_iter().enumerate();
        write_csv(path, &columns.map(|(at, head)| (head, self.shown(at))).collect::<Vec<_>>())
    }

    /// Groups for `arviz`: posterior, prior, replicated and observed data, the likelihood of each datum, and further quantities of the posterior such as
    /// volumes, by name, place among the observables and size of their unit.
    pub fn to_arviz(&self, further: &[(String, usize, f64)]) -> ArvizDict {
        let mut dict = ArvizDict::default();
        for (at, head) in self.heads().iter().enumerate() {
            dict = dict.with("posterior", head, self.shown(at));
        }
        for (name, observable, size) in further {
            let mut chains = self.observed.parameter(*observable);
            chains.iter_mut().flatten().for_each(|value| *value /= size);
            dict = dict.with("posterior", name, chains);
        }
        dict = self.with_prior(dict);
        let mut random = ChaCha8Rng::seed_from_u64(split_seed(self.seed, REPLICATES));
        for (at, datum) in self.problem.data.iter().enumerate() {
            let mut chains = self.observed.parameter(datum.observable);
            for (chain, draws) in chains.iter_mut().zip(&self.coordinates.draws) {
                let noise = standard_normals(chain.len(), &mut random);
                for ((value, z), y) in chain.iter_mut().zip(noise).zip(draws) {
                    let factor = self.problem.log_factor(at, &self.problem.log_factors(y)).exp();
                    *value = datum.with_error(*value, z * factor) / datum.size;
                }
            }
            dict = dict.with("posterior_predictive", &datum.name, chains);
            dict = dict.with_observed(&datum.name, datum.value / datum.size);
        }
        let labels = self.problem.data.iter().map(|datum| datum.name.clone()).collect();
        dict.with_log_likelihood(labels, self.log_likelihood())
    }

    /// Draws of the prior, as many.
    fn with_prior(&self, mut dict: ArvizDict) -> ArvizDict {
        let mut random = ChaCha8Rng::seed_from_u64(split_seed(self.seed, PRIOR));
        let shape: Vec<usize> = self.draws.draws.iter().map(Vec::len).collect();
        let unknowns = self.problem.unknowns.iter().map(Some);
        let all = unknowns.chain(self.problem.inferred_kinds().map(|_| None));
        for (head, unknown) in self.heads().iter().zip(all) {
            let value = |y: f64| match unknown {
                Some(unknown) => unknown.shown(unknown.prior.logarithm(y)[0].exp()),
                None => (FACTOR_DEVIATION * y).exp(),
            };
            let chain = |&count: &usize| {
                standard_normals(count, &mut random).into_iter().map(value).collect()
            };
            dict = dict.with("prior", head, shape.iter().map(chain).collect());
        }
        dict
    }
}

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
