//! The result: draws of the solver's posterior and what they say.

use crate::problem::FACTOR_DEVIATION;
use crate::verify::Verified;
use crate::{Correction, Identifiability, Identified, Mode, Predictive, Problem};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_sample::{
    ArvizDict, Chains, SampleError, Summary, split_seed, standard_normals, write_csv,
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
            identifiability: Identifiability::new(problem, &mode.information),
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
