//! Draws in chains, and summaries of a parameter.

use crate::mixing::{mean, variance};
use crate::{ess_bulk, ess_tail, quantile, r_hat};

/// Draws of a sampler.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chains {
    /// Parameters by chain and draw; all chains have equally many draws.
    pub draws: Vec<Vec<Vec<f64>>>,
}

/// Moments, quantiles and mixing of one parameter.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Summary {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
    /// 2.5 %, 50 % and 97.5 % quantile.
    pub quantiles: [f64; 3],
    /// R̂.
    pub r_hat: f64,
    /// Effective sample size of the bulk.
    pub ess_bulk: f64,
    /// Effective sample size of the tails.
    pub ess_tail: f64,
}

impl Chains {
    /// Values of one parameter, chain by chain.
    pub fn parameter(&self, index: usize) -> Vec<Vec<f64>> {
        self.draws.iter().map(|chain| chain.iter().map(|draw| draw[index]).collect()).collect()
    }

    /// All draws, chain after chain.
    pub fn pooled(&self) -> impl Iterator<Item = &Vec<f64>> {
        self.draws.iter().flatten()
    }

    /// Chains thinned to this number of draws at equal distances, the last among them; all if there are fewer.
    pub fn thinned(&self, per_chain: usize) -> Self {
        let thin = |chain: &Vec<Vec<f64>>| {
            let kept = per_chain.min(chain.len());
            (1..=kept).map(|i| chain[i * chain.len() / kept - 1].clone()).collect()
        };
        Self { draws: self.draws.iter().map(thin).collect() }
    }

    /// Summary of one parameter.
    pub fn summary(&self, index: usize) -> Summary {
        Summary::of(&self.parameter(index))
    }

    /// Largest R̂, and smallest effective sample sizes of bulk and tails, over all parameters.
    pub fn mixing(&self) -> [f64; 3] {
        let count = self.pooled().next().map_or(0, Vec::len);
        let all = (0..count).map(|index| self.summary(index));
        all.fold([1.0, f64::INFINITY, f64::INFINITY], |[r_hat, bulk, tail], s| {
            [r_hat.max(s.r_hat), bulk.min(s.ess_bulk), tail.min(s.ess_tail)]
        })
    }

    /// A function of each draw, by chain.
    pub fn mapped(&self, of: impl Fn(&[f64]) -> Vec<f64>) -> Self {
        let chain = |chain: &Vec<Vec<f64>>| chain.iter().map(|draw| of(draw)).collect();
        Self { draws: self.draws.iter().map(chain).collect() }
    }
}

impl Summary {
    /// Summary of a quantity by chain and draw.
    pub fn of(chains: &[Vec<f64>]) -> Self {
        let all = chains.concat();
        Self {
            mean: mean(&all),
            deviation: variance(&all).sqrt(),
            quantiles: [0.025, 0.5, 0.975].map(|share| quantile(&all, share)),
            r_hat: r_hat(chains),
            ess_bulk: ess_bulk(chains),
            ess_tail: ess_tail(chains),
        }
    }
}
